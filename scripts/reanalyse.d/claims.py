"""The verdicts: claims.csv from the ratios, the trees, the drawings and the misses, by the rules of docs/protocol.md and claims.toml."""

import math
from dataclasses import dataclass, replace

import numpy as np

from estimate import RESAMPLES, over_launches, strictness, student_tails
from study import ALL

METRICS = {
    "time-ratio": ["program-time", "time"],
    "volume-test-ratio": ["volume-tests"],
    "triangle-test-ratio": ["triangle-tests"],
    "build-ratio": ["build"],
}
QUERIES = ["time-ratio", "volume-test-ratio", "triangle-test-ratio"]
COLUMNS = ["verdict", "effect", "value", "low", "high", "missed", "baseline_missed"]
EDGES = 7  # the first axis that is a product of edges


@dataclass
class Finding:
    """A row of claims.csv. `p` is (least, likely, most), since the error of a resampled ratio is itself resampled; None of what is counted."""

    verdict: str
    effect: str = "-"
    value: float = math.nan
    low: float = math.nan
    high: float = math.nan
    workload: str = "-"
    stratum: str = "-"
    p: tuple = None
    reading: str = "-"
    scene: str = "-"
    missed: float = math.nan
    baseline_missed: float = math.nan
    tied: tuple = ()  # of a primary row: the rows that may be the deciding one as well, since their p overlap with its


NOT_JUDGED = Finding("not-judged")


def fewest(study, scene, metric):
    """Fewest units that decide: two launches or binaries, else four clusters."""
    over_launches = metric.startswith("program-time") or (metric == "build" and study.builds[study.builds.scene == scene].launch.nunique() > 1)
    return 2 if over_launches else 4


def effect_of(low, high):
    """less, same, more or unclear, whatever is claimed."""
    if 0.95 <= low and high <= 1.05:
        return "same"
    return "less" if high < 1 else "more" if low > 1 else "unclear"


def threshold(test):
    """The bound that supports."""
    return test.get("at_most", test.get("below", 0.95))


def refuted_from(test):
    """The bound that refutes: of a sentence that names no margin, no effect at all."""
    return threshold(test) if "at_most" in test or test.get("names_margin") else 1.0


def decide(test, low, high):
    """The verdict on a ratio with this interval."""
    if test.get("direction") == "greater":
        low, high = 1 / high, 1 / low
    if "at_most" in test:
        return "supported" if high <= test["at_most"] else "refuted" if low > test["at_most"] else "undecided"
    return "supported" if high < threshold(test) else "refuted" if low >= refuted_from(test) else "undecided"


def p_range(found, test, errors, verdict):
    """p at the bound that the verdict is about, with what resampling leaves open: the error's own error, from the fourth moments, so many times."""
    value = 1 / found.value if test.get("direction") == "greater" else found.value
    distance = math.log(value / (refuted_from(test) if verdict == "refuted" else threshold(test)))
    if found.freedom < 1:
        return 1.0, 1.0, 1.0
    if found.error == 0:
        return (float(distance == 0),) * 3
    slack = 1e-6
    if found.deviations is not None:
        squares = found.deviations**2
        slack = errors * squares.std() / squares.mean() / 2 * math.sqrt(1 / RESAMPLES + 1 / len(squares))
    t = abs(distance) / found.error
    return tuple(student_tails(t * factor, found.freedom) for factor in (1 + slack, 1.0, max(0.0, 1 - slack)))


class Judge:
    """Judges the readings of one study."""

    def __init__(self, derivation, study, ratios, noisy, errors):
        self.derivation, self.study, self.ratios, self.noisy, self.errors = derivation, study, ratios, noisy, errors

    def find(self, test, scene, subject, baseline):
        """The findings of a test in a scene."""
        kind = test["kind"]
        if kind in METRICS:
            return self.ratio(test, scene, subject, baseline)
        if kind == "misses":
            return self.misses(test, scene, subject, baseline)
        if kind in ("overhang", "drift", "gap"):
            return [self.presence(test, scene, subject, baseline)]
        examined = subject if test.get("of") == "subject" else baseline
        return [{
            "balance": lambda: self.trees(test, scene, "child_ratio", baseline, subject),
            "bytes-ratio": lambda: self.trees(test, scene, "bytes", subject, baseline),
            "tightness": lambda: self.tightness(test, scene, subject, baseline),
            "axis-operations": lambda: self.exits(test, scene, examined, lambda rows: rows.operations),
            "edge-exits": lambda: self.exits(test, scene, examined, lambda rows: (rows.axis >= EDGES).astype(float)),
        }[kind]()]  # fmt: skip

    def ratio(self, test, scene, subject, baseline):
        findings = []
        for (where, workload, stratum, metric, above, below), (found, row) in self.ratios.items():
            asked = stratum == test["stratum"] if "stratum" in test else stratum in (ALL, "-")
            if (where, above, below) != (scene, subject, baseline) or metric not in METRICS[test["kind"]] or not asked:
                continue
            few = row.clusters < fewest(self.study, scene, metric)
            loud = metric in ("time", "program-time") and (scene, workload, stratum) in self.noisy
            verdict = "undecided" if few or loud else decide(test, row.low, row.high)
            findings.append(Finding(
                verdict,
                "unclear" if few or loud else effect_of(row.low, row.high),
                row.ratio, row.low, row.high, workload, stratum,
                (1.0, 1.0, 1.0) if few or loud else p_range(found, test, self.errors, verdict),
            ))  # fmt: skip
        return findings or [NOT_JUDGED]

    def of_case(self, table, scene, case):
        rows = getattr(self.study, table)
        return rows[(rows.scene == scene) & (rows.case == case)]

    def geometric(self, test, logs):
        logs = logs[np.isfinite(logs)]
        if not len(logs):
            return NOT_JUDGED
        value = math.exp(logs.mean())
        return Finding(decide(test, value, value), effect_of(value, value), value)

    def trees(self, test, scene, column, above, below):
        """Part by part, the geometric mean."""
        pair = [self.of_case("trees", scene, case).set_index("part")[column].astype(float) for case in (above, below)]
        with np.errstate(invalid="ignore", divide="ignore"):
            return self.geometric(test, np.log(pair[0] / pair[1]).to_numpy())

    def tightness(self, test, scene, subject, baseline):
        """Volume over hull volume, by part and level, in the parts' own frame or in random ones."""
        pair = []
        for case in (subject, baseline):
            rows = self.of_case("tightness", scene, case)
            rows = rows[(rows.frame > 0) == (test.get("frames") == "random")]
            rows = rows if "level" not in test else rows[rows.level == test["level"]]
            pair.append((rows.hulled_volume_mm3 / rows.hull_mm3).to_numpy())
            pair[-1] = rows.assign(loose=pair[-1]).set_index(["frame", "part", "level"]).loose
        with np.errstate(invalid="ignore", divide="ignore"):
            logs = np.log(pair[0] / pair[1])
        logs = logs[np.isfinite(logs)]
        if test.get("frames") != "random":
            return self.geometric(test, logs.to_numpy())
        frames = np.exp(logs.groupby("frame").mean().to_numpy())
        if not len(frames):
            return NOT_JUDGED
        found = over_launches(frames, np.ones(len(frames)))
        value = math.exp(np.log(frames).mean())
        found.ends = tuple(end * value / found.value for end in found.ends)
        found.value = value
        few = len(frames) < 4
        verdict = "undecided" if few else decide(test, *found.ends)
        p = (1.0, 1.0, 1.0) if few else p_range(found, test, self.errors, verdict)
        return Finding(verdict, effect_of(*found.ends), value, *found.ends, p=p)

    def exits(self, test, scene, case, value):
        """The mean over all volume tests."""
        rows = self.of_case("exits", scene, case)
        if not rows.tests.sum():
            return NOT_JUDGED
        mean = float((value(rows) * rows.tests).sum() / rows.tests.sum())
        return Finding("supported" if mean <= test["at_most"] else "refuted", value=mean, stratum=ALL)

    # Presence

    def presence(self, test, scene, subject, baseline):
        found = getattr(self, test["kind"])
        repairs = test["expect"] == "absent" and test["of"] == "subject"
        finding = found(test, scene, subject if test["of"] == "subject" else baseline, test["expect"] == "present")
        if repairs and finding.verdict != "not-judged":
            fault = found(test, scene, baseline, True)
            there = fault.verdict != "refuted"
            if test["kind"] == "drift":
                there = (self.of_case("trees", scene, baseline).drift_mm > test["above"]).any()
            if not there:
                finding = replace(finding, verdict="not-applicable")
        return finding

    def misses(self, test, scene, subject, baseline):
        """One finding for each workload."""
        case, expected = subject if test["of"] == "subject" else baseline, test["expect"] == "present"
        workloads = sorted(w for s, c, w in self.derivation.tallies if (s, c) == (scene, case))
        findings = []
        for workload in workloads:
            contacts, missed, (low, high), _, _ = self.derivation.misses(scene, case, workload)
            if contacts == 0 or (missed == 0 and high > test["above"]):
                verdict = "undecided"
            else:
                verdict = "supported" if (missed > 0) == expected else "refuted"
            repairs = not expected and test["of"] == "subject"
            if repairs and self.derivation.misses(scene, baseline, workload)[1] == 0:
                verdict = "not-applicable"
            value = missed / contacts if contacts else math.nan
            findings.append(Finding(verdict, value=value, low=low, high=high, workload=workload, stratum="colliding"))
        return findings or [NOT_JUDGED]

    def overhang(self, test, scene, case, expected):
        rows = self.of_case("tightness", scene, case)
        rows = rows[rows.frame == 0]
        if not len(rows):
            return NOT_JUDGED
        worst = rows.outside_corners_pct.max()
        return Finding("supported" if (worst > test["above"]) == expected else "refuted", value=worst)

    def drift(self, test, scene, case, expected):
        drifts = self.of_case("trees", scene, case).drift_mm.to_numpy()
        if not len(drifts):
            return NOT_JUDGED
        displaced = drifts[abs(drifts) > test["above"]]
        if expected:
            verdict = "supported" if len(displaced) and (displaced > 0).all() else "refuted"
        else:
            verdict = "refuted" if (displaced > 0).any() else "supported"
        return Finding(verdict, value=drifts[abs(drifts).argmax()])

    def gap(self, test, scene, case, expected):
        outlines = self.study.outlines[self.study.outlines.scene == scene]
        drawn = outlines[outlines.variant == self.study.cases.loc[case].variant]
        found = []
        for part, rows in drawn.groupby("part"):
            mesh = outlines[(outlines.part == part) & (outlines.variant == "mesh")]
            found.extend(displacement(ends(rows), ends(mesh)))
        if not found:
            return NOT_JUDGED
        overhang, empty = max(found)
        if overhang <= test["above"]:
            return Finding("refuted" if expected else "supported")
        there = abs(empty / overhang - 1) <= 0.1
        return Finding("supported" if there == expected else "refuted", value=empty / overhang)


def ends(rows):
    """Both ends of every segment, in turn."""
    return rows[["x1_mm", "y1_mm", "z1_mm", "x2_mm", "y2_mm", "z2_mm"]].to_numpy().reshape(-1, 3)


def displacement(corners, mesh):
    """Along each axis of a drawn box: how far the mesh sticks out of it, and how far it stays short at the other side."""
    if not len(corners) or not len(mesh):
        return []
    axes = []
    for edge in corners[1::2] - corners[::2]:
        length = np.linalg.norm(edge)
        if length > 0 and all(abs(axis @ edge) < 1e-6 * length for axis in axes):
            axes.append(edge / length)
    if len(axes) != 3:
        return []
    centre = corners.mean(axis=0)
    sides = []
    for axis in axes:
        reach, along = abs((corners - centre) @ axis).max(), (mesh - centre) @ axis
        sides.append(sorted([along.max() - reach, -along.min() - reach]))
    short, out = max(sides, key=lambda side: side[1])
    return [(out, -short)]


def primary_of(claim, findings, scenes):
    """The row that answers a sentence, and the number of its scenes."""
    test, workload, stratum = claim["test"], None, None
    if test["kind"] in QUERIES:
        stratum = test.get("stratum", ALL)
        usual = "program-time" if test["kind"] == "time-ratio" and stratum == ALL else "program"
        workload = test.get("workload", usual)
    asked = [
        f for f in findings
        if f.reading == claim["primary"] and f.verdict != "not-judged" and (not scenes or f.scene in scenes)
        and workload in (None, f.workload) and stratum in (None, f.stratum)
    ]  # fmt: skip
    if not asked:
        return replace(NOT_JUDGED, reading=claim["primary"])
    if test["kind"] == "misses":
        asked = of_scenes(asked, test["expect"] == "present")

    def p(finding):
        return finding.p[1] if finding.p else 0.0

    verdicts = [f.verdict for f in asked]
    applicable = [f for f in asked if f.verdict != "not-applicable"]
    refuted = [f for f in asked if f.verdict == "refuted"]
    if not applicable:
        verdict = "not-applicable"
    elif all(f.verdict == "supported" for f in applicable):
        verdict = "supported"
    else:
        verdict = "refuted" if "refuted" in verdicts else "undecided"
    deciding = min(refuted, key=p) if refuted else applicable[last_largest([p(f) for f in applicable])] if applicable else asked[0]
    tied = [f for f in refuted or applicable if f.p and deciding.p and f.p[0] <= deciding.p[2] and f.p[2] >= deciding.p[0]]
    corrected = deciding.p
    if tied:
        times = len(asked) if verdict == "refuted" else 1
        range_of = (min(f.p[0] for f in tied), deciding.p[1], max(f.p[2] for f in tied))
        corrected = tuple(min(1.0, times * value) for value in range_of)
    if verdict != "refuted" and set(scenes) - {f.scene for f in asked}:
        verdict, corrected = "undecided", corrected and (1.0, 1.0, 1.0)
    return replace(deciding, verdict=verdict, scene="+".join(f.scene for f in asked), p=corrected, tied=tuple(tied))


def of_scenes(findings, expected):
    """Of each scene the workload that decides: misses are there in one, or nowhere. Of equal verdicts the one with the largest rate."""
    order = ["supported", "undecided", "refuted"] if expected else ["refuted", "undecided", "supported"]
    order = [*order, "not-applicable"]
    best = {}
    for finding in findings:
        rank = (order.index(finding.verdict), -np.nan_to_num(finding.value))
        if finding.scene not in best or rank < best[finding.scene][0]:
            best[finding.scene] = (rank, finding)
    return [finding for _, finding in best.values()]


def last_largest(values):
    """Of equal ones the last."""
    return max(range(len(values)), key=lambda i: (values[i], i))


def holm(primaries):
    """p after Holm's correction, in its three forms; a decided row above 0.05 is undecided."""
    family = sorted((row for row in primaries if row.p), key=lambda row: row.p[1])
    adjusted = (0.0, 0.0, 0.0)
    for place, row in enumerate(family):
        adjusted = tuple(max(before, min(1.0, (len(family) - place) * p)) for before, p in zip(adjusted, row.p))
        row.p = adjusted
        if row.verdict in ("supported", "refuted") and adjusted[1] > 0.05:
            row.verdict = "undecided"


def claim_rows(differences, derivation, study, ratios, noisy):
    """Compares claims.csv."""
    errors = strictness(differences.ends or 1)
    judge = Judge(derivation, study, ratios, noisy, errors)
    readings = {reading["id"]: reading for reading in study.claims.get("reading", [])}
    named = study.claims["comparison"].get("scenes", [])
    scenes = named if any(name in study.scenes for name in named) else []
    primaries, rows = [], []
    for claim in study.claims.get("claim", []):
        if "test" not in claim:
            rows.append((claim["id"], "primary", NOT_JUDGED))
            continue
        findings = []
        for reading in claim["readings"]:
            subject, baseline = (study.referred(readings[reading][role]) for role in ("subject", "baseline"))
            if not subject or not baseline:
                findings.append(replace(NOT_JUDGED, reading=reading))
                continue
            for scene in sorted(study.scenes):
                missed = [tally[1] if tally else math.nan for tally in (derivation.misses(scene, case) for case in (subject, baseline))]
                for finding in judge.find(claim["test"], scene, subject, baseline):
                    told = dict(reading=reading, scene=scene, missed=missed[0], baseline_missed=missed[1])
                    findings.append(replace(finding, **told))
        if "primary" in claim:
            primaries.append(primary_of(claim, findings, scenes))
            rows.append((claim["id"], "primary", primaries[-1]))
        rows.extend((claim["id"], "exploratory", finding) for finding in findings)
    if derivation.draws:
        holm(primaries)
    file = "claims.csv"
    keys = ["claim", "role", "reading", "scene", "workload", "stratum"]
    there = {tuple(getattr(row, key) for key in keys): row for row in study.derived[file].itertuples()}
    for claim, role, finding in rows:
        key = (claim, role, finding.reading, finding.scene, finding.workload, finding.stratum)
        row = there.pop(key, None)
        if row is None:
            differences.note(f"{file}: has no row {' '.join(key)}")
            continue
        if role == "primary" and not derivation.draws:
            continue  # which scene decides is a matter of p
        # Which scene decides a primary row is a matter of p: the numbers must be those of one that may.
        numbers = min(finding.tied, key=lambda f: abs(f.value - row.value), default=finding)
        for column in COLUMNS:
            from_row = finding if column == "verdict" else numbers
            differences.same(file, " ".join(key), column, getattr(row, column), getattr(from_row, column))
        if role == "primary":
            least, likely, most = finding.p or (math.nan,) * 3
            differences.points += 1
            fits = math.isnan(row.p_holm) if math.isnan(likely) else least * (1 - 1e-4) <= row.p_holm <= most * (1 + 1e-4)
            if not fits:
                differences.note(f"{file}: {' '.join(key)}: p_holm is {row.p_holm}, expected {likely:.4g}, from {least:.4g} to {most:.4g}")
    for key in there:
        differences.note(f"{file}: row {' '.join(key)} does not follow from the raw rows")



"""See scripts/reanalyse --help."""

import argparse
import math
import sys
from pathlib import Path

import numpy as np

import estimate
from claims import claim_rows, effect_of, fewest
from derive import Derivation, costs, repay
from estimate import Draws, distance, strictness
from report import report_tables
from study import BadInput, Study
from variance import variance_rows

SHOWN = 40
POINT = 1e-9  # relative
TIMES = ["time", "program-time", "program-time-cold"]


class Differences:
    """What differs, and how much was compared."""

    def __init__(self, intervals):
        self.found, self.points, self.ends, self.worst = [], 0, 0, 0.0
        self.intervals, self.waiting = intervals, []

    def note(self, text):
        """Something differs."""
        self.found.append(text)

    def same(self, file, place, column, found, expected):
        """Text, and numbers to POINT."""
        self.points += 1
        if isinstance(expected, str):
            equal = found == expected
        else:
            found, expected = float(found), float(expected)
            equal = (math.isnan(found) and math.isnan(expected)) or abs(found - expected) <= POINT * max(abs(expected), 1e-300)
        if not equal:
            self.note(f"{file}: {place}: {column} is {found}, expected {expected}")

    def interval(self, file, place, ratio, value, low, high, least=-math.inf):
        """A ratio with its ends; those of resamples wait until their number is known. The lower end is not below `least`."""
        self.same(file, place, "value", value, ratio.value)
        if not self.intervals:
            return
        if ratio.ends:
            self.same(file, place, "low", low, ratio.ends[0])
            self.same(file, place, "high", high, ratio.ends[1])
            return
        for name, quantile, end in [("low", 0.025, low), ("high", 0.975, high)]:
            self.ends += 1
            clipped = name == "low" and least > -math.inf and abs(end - least) <= POINT * abs(least)
            self.waiting.append((file, place, name, ratio, quantile, end, clipped))

    def settle(self):
        """Compares the ends that wait."""
        allowed = strictness(self.ends)
        for file, place, name, ratio, quantile, end, clipped in self.waiting:
            if not len(ratio.deviations):
                self.same(file, place, name, end, ratio.value)
                continue
            ours = ratio.value * math.exp(ratio.wider * float(np.quantile(ratio.deviations, quantile)))
            errors = distance(ratio, quantile, end)
            if clipped and ours <= end:
                continue
            self.worst = max(self.worst, errors)
            if errors > allowed:
                self.note(f"{file}: {place}: {name} is {end:.6g}, expected {ours:.6g}: {errors:.1f} standard errors, {allowed:.1f} are allowed")
        self.waiting = []
        return allowed


def pair_up(differences, file, found, expected, keys):
    """Rows of the file with the rows expected, by key; names those that only one of them has."""
    index = {tuple(getattr(row, key) for key in keys): row for row in found.itertuples()}
    if len(index) != len(found):
        differences.note(f"{file}: {len(found) - len(index)} rows have the key of another one")
    for row in expected:
        key = tuple(row[key] for key in keys)
        there = index.pop(key, None)
        if there is None:
            differences.note(f"{file}: has no row {' '.join(map(str, key))}")
        else:
            yield " ".join(map(str, key)), there, row
    for key in index:
        differences.note(f"{file}: row {' '.join(map(str, key))} does not follow from the raw rows")


def is_quiet(ratio, low, high):
    """Whether a null duplicate's ratio lets its cell be judged."""
    return 0.99 <= ratio <= 1.01 and (math.isnan(low) or (0.95 <= low and high <= 1.05))


def check(folder, intervals=True, readme=None):
    """Re-derives everything; the differences."""
    study = Study(folder)
    differences = Differences(intervals)
    derivation = Derivation(study, Draws(study.seed) if intervals else None)

    for text in derivation.contradictions():
        differences.note(text)

    file = "program_times.csv"
    for place, there, row in pair_up(differences, file, study.derived[file], derivation.program_times(), ["scene", "program", "case"]):
        for column in ["ends_at", "queries", "baseline", "total_ns", "total_low_ns", "total_high_ns", "ratio", "low", "high"]:
            differences.same(file, place, column, getattr(there, column), row[column])

    file = "summary.csv"
    for place, there, row in pair_up(differences, file, study.derived[file], derivation.summary(), ["scene", "workload", "stratum", "case"]):
        for column in ["poses", "clusters", "single_poses", "query_p50_ns", "query_p95_ns", "query_p99_ns", "query_max_ns", "chunk_median_ns",
                       "chunk_p95_ns", "chunk_max_ns", "volume_tests", "triangle_tests", "contacts", "missed", "miss_rate_low",
                       "miss_rate_high"]:  # fmt: skip
            differences.same(file, place, column, getattr(there, column), row[column])
        if row["mean_ns"] is None:
            differences.same(file, place, "mean_ns", there.mean_ns, math.nan)
        else:
            least = min(row["least"], row["mean_ns"].value)
            differences.interval(file, place, row["mean_ns"], there.mean_ns, there.mean_low_ns, there.mean_high_ns, least)

    file = "ratios.csv"
    table = study.derived[file]
    for side in ["variant", "baseline"]:
        policies = table["policy" if side == "variant" else "baseline_policy"]
        table["case" if side == "variant" else "below"] = table[side].where(policies == "none/none/0", table[side] + "@" + policies)
    keys = ["scene", "workload", "stratum", "metric", "case", "below"]
    noisy = {
        (row.scene, row.workload, row.stratum): (row.ratio, row.low, row.high)
        for row in table[(table.variant == "null-duplicate") & table.metric.isin(TIMES)].itertuples()
        if not is_quiet(row.ratio, row.low, row.high)
    }
    ratios = {}
    for place, there, row in pair_up(differences, file, table, derivation.ratios(), keys):
        found = row["ratio"]
        ratios[tuple(row[key] for key in keys)] = (found, there)
        differences.same(file, place, "clusters", there.clusters, row["clusters"])
        differences.interval(file, place, found, there.ratio, there.low, there.high)
        few = there.clusters < fewest(study, there.scene, there.metric)
        differences.same(file, place, "effect", there.effect, "unclear" if few else effect_of(there.low, there.high))
        wanted = there.metric in TIMES and (there.scene, there.workload, there.stratum) in noisy
        differences.same(file, place, "noisy", there.noisy, int(wanted))

    variance_rows(differences, derivation, study, pair_up)
    cost, predicted, deadlines = costs(derivation)
    for file, expected, keys, columns in [
        ("costs.csv", cost, ["case"], "setup_ns volume_test_ns triangle_test_ns chunks error_median error_p95"),
        ("cost_chunks.csv", predicted, ["scene", "case", "chunk"], "stratum volume_tests triangle_tests measured_ns predicted_ns"),
        ("deadlines.csv", deadlines, ["scene", "case", "slowdown"], "queries p999_ns over_1_ms over_2_ms over_4_ms over_8_ms"),
        ("repay.csv", repay(derivation), ["scene", "case", "below"], "build_ns query_ns queries"),
    ]:
        table = study.derived[file]
        table["case"] = table.variant.where(table.policy == "none/none/0", table.variant + "@" + table.policy)
        if "baseline" in table:
            table["below"] = table.baseline + "@" + table.baseline_policy
        for place, there, row in pair_up(differences, file, table, expected, keys):
            for column in columns.split():
                differences.same(file, place, column, getattr(there, column), row[column])

    claim_rows(differences, derivation, study, ratios, noisy)
    report_tables(differences, derivation, study, ratios, readme)
    allowed = differences.settle()
    return differences, allowed


def main():
    """The command."""
    parser = argparse.ArgumentParser(prog="scripts/reanalyse")
    parser.add_argument("--home", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--points", action="store_true")
    parser.add_argument("--self-test", action="store_true")
    parser.add_argument("folder", type=Path, nargs="?")
    options = parser.parse_args()
    reference = options.home / "results" / "reference"
    if options.self_test:
        from selftest import self_test

        return self_test(options.folder or reference, options.home / "README.md", check)
    folder = options.folder or reference
    readme = options.home / "README.md" if folder.resolve() == reference.resolve() else None
    try:
        differences, allowed = check(folder, not options.points, readme)
    except BadInput as error:
        print(f"scripts/reanalyse: {error}", file=sys.stderr)
        return 2
    for text in differences.found[:SHOWN]:
        print(text)
    if len(differences.found) > SHOWN:
        print(f"... and {len(differences.found) - SHOWN} more")
    print(f"{folder}: {differences.points} numbers and words compared to {POINT:g}, {len(differences.found)} differ")
    if differences.ends:
        print(
            f"{differences.ends} ends of bootstrap intervals compared with {estimate.OURS} resamples of our own: at most "
            f"{differences.worst:.1f} standard errors apart, {allowed:.1f} are allowed"
        )
    return int(bool(differences.found))


if __name__ == "__main__":
    sys.exit(main())

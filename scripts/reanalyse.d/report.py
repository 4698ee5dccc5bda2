"""The tables of numbers that README.md and report.md quote, written anew and compared word by word."""

import math
import re

from derive import rank
from study import ALL


def number(value):
    """Three significant digits, or more where the whole part has them."""
    size = abs(value)
    if not math.isfinite(value):
        return "-"
    if size == 0:
        return "0"
    for least, digits in [(100, 0), (10, 1), (0.1, 3), (1e-3, 4)]:
        if size >= least:
            return f"{value:.{digits}f}"
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def bound(value):
    """The same, rounded upwards."""
    shown = number(value)
    if shown == "-" or float(shown) >= value:
        return shown
    units = [(100, 1), (10, 0.1), (0.1, 1e-3), (1e-3, 1e-4)]
    unit = next((unit for least, unit in units if value >= least), 10 ** (math.floor(math.log10(value)) - 1))
    return number(value + unit / 2)


def with_interval(value, low, high):
    """A value, with its interval where it has one."""
    return f"{number(value)} [{number(low)}, {number(high)}]" if math.isfinite(low) and math.isfinite(high) else number(value)


def ranking(derivation, study, ratios):
    """The rows of the two tables under "Ranking by speed"."""
    if not derivation.baselines:
        return [], []
    baseline = derivation.baselines[0]
    metric = workload = "program-time"
    if not any(key[3] == metric for key in ratios):
        metric, workloads = "time", {key[1] for key in ratios if key[3] == "time" and key[1] != "control"}
        workload = min(workloads, key=rank, default=None)
    entries, is_ranked, undecided = [], False, set()
    fewest = 2 if metric == "program-time" else 4
    for variant, facts in study.variants.items():
        case = study.default(variant)
        ours = facts["kind"] not in ("peer", "control")
        if case is None or (ours and (not facts["safe"] or derivation.any_missed(variant))):
            continue
        found = {scene: ratios.get((scene, workload, ALL, metric, case, baseline)) for scene in study.scenes}
        values = [pair[0].value for pair in found.values() if pair]
        if facts["kind"] == "volume":
            undecided |= {scene for scene, pair in found.items() if pair and (pair[1].noisy or pair[1].clusters < fewest)}
        if case != baseline and not values:
            continue
        mean = math.exp(sum(map(math.log, values)) / len(values)) if values else 1.0
        tallies = [tally for tally in (derivation.misses(scene, case) for scene in study.scenes) if tally]
        missed = str(sum(tally[4][0] for tally in tallies)) if tallies else "not verified"
        cells = [with_interval(pair[0].value, pair[1].low, pair[1].high) if pair else "-" for pair in found.values()]
        entries.append((facts["kind"] != "volume", mean, [facts["label"], number(mean), *cells, missed]))
        is_ranked |= case != baseline
    if not is_ranked:
        return [], []
    entries.sort(key=lambda entry: entry[:2])
    place_of = "({})" if undecided == set(study.scenes) else "{}"
    volumes = [[place_of.format(place), *cells] for place, (other, _, cells) in enumerate(entries, 1) if not other]
    return volumes, [["-", *cells] for other, _, cells in entries if other]


def contacts_missed(derivation, study):
    """The rows of the table under "Contacts missed"."""
    cases = study.cases
    order = cases.index[cases.duplicate_of == ""]
    order = sorted(order, key=lambda case: (cases.variant[case], cases.split[case], cases.split_axes[case], cases.leaf[case]))
    rows = []
    for scene in sorted(study.scenes):
        for case in order:
            for workload in sorted(w for s, c, w in derivation.tallies if (s, c) == (scene, case)):
                asked, missed, (low, high), lines, (all_missed, all_contacts) = derivation.misses(scene, case, workload)
                rate = "-" if not asked else f"at most {bound(high)}"
                if missed:
                    rate = f"{number(missed / asked)} [{number(low)}, {number(high)}]"
                facts = study.variants[cases.variant[case]]
                promise = "safe" if facts["safe"] else "none"
                rows.append([
                    scene, facts["label"], study.policy(case), promise, workload, str(asked), str(lines), str(missed), rate,
                    f"{all_missed} of {all_contacts}",
                ])  # fmt: skip
    return rows


def tables_after(text, start, end):
    """The tables between two patterns, without their two head lines, cell by cell."""
    match = re.search(f"^{start}$(.*?)(?:^{end}|\\Z)", text, re.MULTILINE | re.DOTALL)
    tables, rows = [], []
    for line in [*(match[1].splitlines() if match else []), ""]:
        if line.startswith("|"):
            rows.append([cell.strip() for cell in line.strip().strip("|").split(" | ")])
        elif rows:
            tables.append(rows[2:])
            rows = []
    return tables


def compare_table(differences, place, found, expected):
    """Notes every row that differs."""
    for row, wanted in zip(found, expected):
        differences.points += len(wanted)
        if row != wanted:
            differences.note(f"{place}: row `{' | '.join(row)}`, expected `{' | '.join(wanted)}`")
    if len(found) != len(expected):
        differences.note(f"{place}: {len(found)} rows, expected {len(expected)}")


def report_tables(differences, derivation, study, ratios, readme):
    """Compares the tables of report.md, where there is one, and of README.md."""
    known = {
        "Ranking by speed": ranking(derivation, study, ratios),
        "Contacts missed": (contacts_missed(derivation, study),),
    }
    report = study.folder / "report.md"
    if report.exists():
        text = report.read_text()
        for heading, expected in known.items():
            found = tables_after(text, f"## {heading}", "## ")
            for table, wanted in zip(found, expected):
                compare_table(differences, f"report.md, {heading}", table, wanted)
            if len(found) < len([rows for rows in expected if rows]):
                differences.note(f"report.md: a table is missing under {heading}")
    if readme is None:
        return
    text = readme.read_text()
    headings = re.findall(r"^<!-- table: (.*) -->$", text, re.MULTILINE)
    if not headings:
        differences.note("README.md: quotes no table")
    for heading in headings:
        if heading not in known:
            differences.note(f"README.md: quotes the table {heading}, which is not re-derived: add it to scripts/reanalyse.d/report.py")
            continue
        found = tables_after(text, f"<!-- table: {heading} -->", "<!-- end -->")
        compare_table(differences, f"README.md, {heading}", found[0] if found else [], known[heading][0])

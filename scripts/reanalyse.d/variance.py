"""variance.csv: what binary, launch and block contribute to the spread of a total, and the repetitions planned from that, as
docs/methodology.md describes them under "Repetition"."""

import functools
import math

import numpy as np

from estimate import student
from study import ALL

HALF_WIDTH = math.log1p(0.025)
BINARIES, LAUNCHES, BLOCKS = range(5, 65), range(1, 5), 16
SAMPLE_NS = 1e5


class Samples:
    """The times of one pass of a scene, ns, by case: a matrix of launches and chunks by block, NaN where a block was left out."""

    def __init__(self, study, scene):
        timings = study.timings[study.timings.scene == scene]
        timings = timings.assign(ns=timings.ns / timings.passes)
        chunks = study.chunks_of(scene).set_index("chunk")
        self.weights = functools.partial(study.weights, scene)
        self.launches = study.binaries[scene] or [sorted(set(timings.launch))]
        self.tables = {}
        for case, rows in timings.groupby("case"):
            rows = rows.assign(workload=rows.chunk.map(chunks.workload))
            for workload, here in rows.groupby("workload"):
                self.tables[case, workload] = here.pivot(index=["launch", "chunk"], columns="block", values="ns")
        builds = study.builds[study.builds.scene == scene]
        blocks = len(timings[["launch", "block"]].drop_duplicates())
        self.block = (timings.ns + timings.ns.clip(lower=SAMPLE_NS)).sum() / blocks
        self.launch = builds.ns.sum() / (1 + max(timings.launch.max(), builds.launch.max())) + self.block

    def logs(self, workload, case, below):
        """The logarithm of the total, or of the ratio of totals, by binary, launch and block; and whether any chunk has several blocks."""
        tables = [self.tables.get((name, workload)) for name in ([case, below] if below else [case])]
        if any(table is None for table in tables):
            return None, False
        every = [launch for launches in self.launches for launch in launches]
        common = None
        for table in tables:
            seen = table.index.to_frame(index=False).groupby("chunk").launch.agg(set)
            here = {chunk for chunk, launches in seen.items() if launches >= set(every)}
            common = here if common is None else common & here
        if not common:
            return None, False
        blocks = sorted(set().union(*(table.columns for table in tables)))
        totals = []
        for table in tables:
            kept = table[table.index.get_level_values("chunk").isin(common)]
            median = kept.median(axis=1)
            filled = kept.reindex(columns=blocks).apply(lambda column: column.fillna(median))
            weights = self.weights(workload, ALL, filled.index.get_level_values("chunk").to_numpy(), slice(None))
            totals.append((filled * weights).groupby(level="launch").sum())
        values = np.log(totals[0] / totals[1]) if below else np.log(totals[0])
        several = any((table.notna().sum(axis=1) > 1).any() for table in tables)
        return [[values.loc[launch].to_numpy() for launch in launches] for launches in self.launches], several


def components(logs, several):
    """Mean, the three standard deviations, and the half-widths of the two intervals; NaN of what was not repeated."""
    logs = np.array(logs)  # binaries, launches, blocks
    binaries, launches, blocks = logs.shape
    of_launch, of_binary = logs.mean(axis=2), logs.mean(axis=(1, 2))
    nothing = math.nan
    block = logs.var(axis=2, ddof=1).mean() if blocks > 1 and several else nothing
    within = of_launch.var(axis=1, ddof=1).mean() if launches > 1 else nothing
    between = of_binary.var(ddof=1) if binaries > 1 else nothing
    launch = max(0.0, within - np.nan_to_num(block) / blocks) if launches > 1 else nothing
    binary = max(0.0, between - np.nan_to_num(within) / launches) if binaries > 1 else nothing
    half_within = student(binaries * (launches - 1)) * math.sqrt(within / (binaries * launches)) if launches > 1 else nothing
    half = student(binaries - 1) * math.sqrt(between / binaries) if binaries > 1 else half_within
    return of_binary.mean(), (binary, launch, block), half, half_within


def plan(variances, samples):
    """Binaries, launches and blocks; NaN where they cannot be told."""
    binary, launch, block = variances
    if any(map(math.isnan, variances)):
        return (math.nan,) * 3
    if block == 0:
        most = 1
    elif launch == 0:
        most = BLOCKS
    else:
        most = min(BLOCKS, max(1, math.ceil(math.sqrt(samples.launch / samples.block * block / launch))))

    def is_enough(binaries, launches, blocks):
        error = math.sqrt(binary / binaries + launch / (binaries * launches) + block / (binaries * launches * blocks))
        return student(binaries - 1) * error <= HALF_WIDTH

    for binaries in BINARIES:
        for launches in LAUNCHES:
            if is_enough(binaries, launches, most):
                return binaries, launches, next(blocks for blocks in range(1, most + 1) if is_enough(binaries, launches, blocks))
    return (math.nan,) * 3


def expected(study, derivation):
    """The rows of variance.csv."""
    baseline = derivation.baselines[0] if derivation.baselines else None
    for scene in sorted(study.scenes):
        samples = Samples(study, scene)
        workloads = sorted(set(study.chunks_of(scene).workload) - {"control"})
        cases = sorted({case for case, _ in samples.tables})
        for workload in workloads:
            for case in cases:
                for below in [None] + ([baseline] if baseline and baseline != case else []):
                    logs, several = samples.logs(workload, case, below)
                    if logs is None:
                        continue
                    mean, variances, half, half_within = components(logs, several)
                    value = math.exp(mean)
                    planned = plan(variances, samples)
                    yield {
                        "scene": scene, "workload": workload, "case": case, "baseline": below or "",
                        "binaries": len(logs), "launches": len(logs[0]), "blocks": len(logs[0][0]), "value": value,
                        "sd": [math.sqrt(variance) for variance in variances],
                        "low": value * math.exp(-half), "high": value * math.exp(half),
                        "low_within": value * math.exp(-half_within), "high_within": value * math.exp(half_within),
                        "planned_binaries": planned[0], "planned_launches": planned[1], "planned_blocks": planned[2],
                    }  # fmt: skip


def variance_rows(differences, derivation, study, pair_up):
    """Compares variance.csv, where the run has it."""
    file = "variance.csv"
    table = study.derived[file]
    if not len(table) and not (study.folder / file).exists():
        return
    for place, there, row in pair_up(differences, file, table, expected(study, derivation), ["scene", "workload", "case", "baseline"]):
        for column in ["binaries", "launches", "blocks", "value", "low", "high", "low_within", "high_within", "planned_binaries",
                       "planned_launches", "planned_blocks"]:  # fmt: skip
            differences.same(file, place, column, getattr(there, column), row[column])
        # A component may be the difference of two that are nearly the same: to 1e-9 of the largest.
        largest = np.nanmax([*row["sd"], 1e-6])
        for column, sd in zip(["binary_sd", "launch_sd", "block_sd"], row["sd"]):
            found = getattr(there, column)
            if math.isnan(found) != math.isnan(sd) or abs(found**2 - sd**2) > 1e-9 * largest**2:
                differences.note(f"{file}: {place}: {column} is {found}, expected {sd}")
            differences.points += 1



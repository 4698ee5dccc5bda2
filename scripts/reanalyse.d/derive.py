"""Program times, summaries, ratios, misses and costs from the raw rows. Each function gives a list of rows, each a dictionary: plain numbers
are points, `Ratio`s have an interval."""

import functools
import itertools
import math

import numpy as np

from estimate import over_launches, rate_by_line, ratio, repeated, type7, weighted
from study import ALL, in_cell

PROGRAM_TIME = "program-time"
COLD = "program-time-cold"
# The workloads by which a scene without programs is ranked, the first that it has.
RANKING = ["recorded", "program", "approach", "random"]


def rank(workload):
    """Key of a workload in that order, others behind it by name."""
    return RANKING.index(workload) if workload in RANKING else len(RANKING), workload


class Derivation:
    """A study with what several tables share. `draws` is None where only points are wanted."""

    def __init__(self, study, draws):
        self.study, self.draws = study, draws
        self.queries = {key: rows for key, rows in study.queries.groupby(["scene", "case"])}
        self.builds = {key: rows for key, rows in study.builds.groupby(["scene", "case"])}
        singles = study.singles.merge(study.poses[["scene", "pose", "workload", "stratum", "program"]], on=["scene", "pose"], how="left")
        self.cold = {key: rows for key, rows in singles[singles.cache == "cold"].groupby(["scene", "case"])}
        self.warm = {key: rows for key, rows in singles[singles.cache == "warm"].groupby(["scene", "case"])}
        self.tallies = self.tally()
        baselines = study.claims["comparison"]["baselines"]
        self.baselines = [case for case in map(study.default, baselines) if case]

    # Program times

    @functools.cache
    def programs(self, scene):
        """The programs of a scene that were timed as wholes, in the order of their chunks; the index is the chunk's place."""
        chunks = self.study.chunks_of(scene)
        return chunks[chunks.workload == PROGRAM_TIME]

    @functools.cache
    def program_totals(self, scene, case, program):
        """Total time of a program, or of all, by launch; None where one was not timed."""
        times, programs = self.study.times.get((scene, case)), self.programs(scene)
        wanted = programs.index if program == ALL else programs.index[programs.program == program]
        if times is None or not len(wanted) or np.isnan(times[wanted]).any():
            return None
        return times[wanted].sum(axis=0)

    def program_ratio(self, scene, above, below, program):
        """The ratio of two cases' program times."""
        totals = [self.program_totals(scene, case, program) for case in (above, below)]
        if any(total is None for total in totals):
            return None
        return over_launches(*(repeated(total, self.study.binaries[scene]) for total in totals))

    def cold_ratio(self, scene, above, below, program):
        """The ratio of two cases' cold queries, at the poses that both were asked in a launch."""
        rows = self.cold.get((scene, above)), self.cold.get((scene, below))
        if any(table is None for table in rows):
            return None
        both = rows[0].merge(rows[1], on=["launch", "pose"], suffixes=("", "_below"))
        both = both if program == ALL else both[both.program == program]
        sums = both.groupby("launch")[["ns", "ns_below"]].sum()
        place = self.study.binary_of(scene)
        by_binary = sums.groupby(sums.index.map(lambda launch: place.get(launch, 0))).sum()
        sums = by_binary if len(by_binary) > 1 else sums
        return over_launches(sums.ns, sums.ns_below) if len(sums) else None

    def program_times(self):
        """The rows of program_times.csv."""
        baseline = self.baselines[0] if self.baselines else None
        for scene, case in self.study.times:
            programs = self.programs(scene)
            for program in [ALL, *programs.program]:
                totals = self.program_totals(scene, case, program)
                if totals is None:
                    continue
                # The mean of the launches is their sum over their number, and their spread that of logarithms.
                totals = repeated(totals, self.study.binaries[scene])
                total = over_launches(totals, np.ones(len(totals)))
                against = baseline and self.program_ratio(scene, case, baseline, program)
                wanted = programs if program == ALL else programs[programs.program == program]
                end = "collision" if (wanted.ends_in_contact == 1).all() else "end"
                yield {
                    "scene": scene, "program": program, "case": case,
                    "ends_at": "-" if program == ALL else end, "queries": int(wanted.poses.sum()),
                    "total_ns": total.value, "total_low_ns": total.ends[0], "total_high_ns": total.ends[1],
                    "baseline": baseline or "",
                    "ratio": against.value if against else math.nan,
                    "low": against.ends[0] if against else math.nan, "high": against.ends[1] if against else math.nan,
                }  # fmt: skip

    # Misses

    def tally(self):
        """Contacts asked and missed by line, for each scene, case and workload."""
        study = self.study
        keys = ["scene", "workload", "pair", "line"]
        tallies = {}
        for case, row in study.cases.iterrows():
            if row.kind == "control" or row.duplicate_of:
                continue
            missed = study.misses[study.misses.case == case].drop(columns="case")
            lines = study.lines.merge(missed, on=keys, how="left").fillna({"missed": 0, "missed_asked": 0})
            lines["asked"] = lines.contacts if row.asked_everywhere else lines.sampled
            for (scene, workload), rows in lines.groupby(["scene", "workload"]):
                asked = rows[rows.asked > 0]
                by_witness = row.kind in ("volume", "engine", "sampling")
                tallies[scene, case, workload] = {
                    "lines": list(zip(asked.missed_asked, asked.asked)),
                    "all": (int(rows.missed.sum()), int((rows.contacts if by_witness else rows.sampled).sum())),
                }
        return tallies

    def misses(self, scene, case, workload=None):
        """Contacts asked, missed, interval, lines, and (missed, contacts) with answers by witness; over all workloads without one. None where
        the case was not verified."""
        found = [t for (s, c, w), t in self.tallies.items() if (s, c) == (scene, case) and workload in (None, w)]
        if not found and workload is None:
            return None
        lines = [line for tally in found for line in tally["lines"]]
        missed, contacts = [line[0] for line in lines], [line[1] for line in lines]
        everything = tuple(sum(tally["all"][i] for tally in found) for i in (0, 1))
        return int(sum(contacts)), int(sum(missed)), rate_by_line(missed, contacts), len(lines), everything

    def any_missed(self, variant):
        """Whether a variant missed a contact anywhere."""
        cases = set(self.study.cases.index[self.study.cases.variant == variant])
        return any(tally["all"][0] > 0 for (_, case, _), tally in self.tallies.items() if case in cases)

    def contradictions(self):
        """Where verification.csv, poses.csv and answers.csv do not say the same as lines.csv and misses.csv."""
        study = self.study
        bands = study.verification[~study.verification.band.isin(["grazing", "clear"])]
        keys = ["scene", "workload", "pair"]
        lines = study.lines.groupby(keys)[["contacts", "sampled"]].sum()
        for case, rows in bands.groupby("case"):
            counted = rows.groupby(keys)[["exact", "missed", "asked_exact", "asked_missed"]].sum()
            missed = study.misses[study.misses.case == case].groupby(keys)[["missed", "missed_asked"]].sum()
            missed = missed.reindex(counted.index, fill_value=0)
            row = study.cases.loc[case]
            everywhere = row.asked_everywhere == 1
            there = lines.reindex(counted.index, fill_value=0)
            for name, found, expected in [
                ("contacts of lines.csv", there.contacts, counted.exact if row.kind != "peer" else there.contacts),
                ("contacts asked of lines.csv", there.contacts if everywhere else there.sampled, counted.asked_exact),
                ("missed of misses.csv", missed.missed, counted.missed),
                ("missed_asked of misses.csv", missed.missed_asked, counted.asked_missed),
            ]:
                for place in counted.index[(found != expected).to_numpy()]:
                    yield f"verification.csv: {case} in {' '.join(place)}: {expected[place]}, {name} says {found[place]}"
        queries = study.queries[study.queries.band != "grazing"]
        safe = queries.case.map(study.cases.safe == 1)
        ours = queries.case.map(study.cases.kind != "peer")
        wrong = queries[(ours & (queries.verdict > queries.exact)) | (safe & (queries.verdict < queries.exact))]
        for row in wrong.itertuples():
            yield f"answers.csv: {row.case} at pose {row.pose} of {row.scene} says {row.verdict}, poses.csv {row.exact}"

    # Summaries

    @functools.cache
    def cell(self, scene, workload, stratum):
        """Which chunks and which poses of a scene are in a cell."""
        return tuple(np.flatnonzero(in_cell(of(scene), workload, stratum)) for of in (self.study.chunks_of, self.study.poses_of))

    def numbers(self, scene, places, of="chunks"):
        """The numbers of the chunks at these places of the chunks, or of the poses, of a scene."""
        return self.study.column(of, scene, "chunk")[places]

    def mean_time(self, scene, case, workload, stratum):
        """Mean query time in a cell; None where it was not timed."""
        times, (chunks, _) = self.study.times.get((scene, case)), self.cell(scene, workload, stratum)
        if times is None:
            return None
        drawn_in, cluster, poses = (self.study.column("chunks", scene, name)[chunks] for name in ("drawn_in", "cluster", "poses"))
        above = times[chunks]
        weights = self.study.weights(scene, workload, stratum, self.numbers(scene, chunks), ~np.isnan(above).all(axis=1))
        below = np.where(np.isnan(above), np.nan, poses[:, None])
        return ratio(drawn_in, cluster, above * weights, below * weights, self.draws, self.study.binaries[scene])

    def single_times(self, scene, case, workload, stratum):
        """Of each pose of a cell the median reading over a single warm query."""
        rows = self.warm.get((scene, case))
        if rows is None:
            return np.array([])
        return rows[in_cell(rows, workload, stratum)].groupby("pose").ns.median().to_numpy()

    def summary(self):
        """The rows of summary.csv."""
        study = self.study
        for scene in sorted(study.scenes):
            cases = sorted({case for place, case in [*study.times, *study.counts] if place == scene})
            for (workload, stratum), case in itertools.product(study.cells(scene), cases):
                mean = self.mean_time(scene, case, workload, stratum)
                chunks, poses = self.cell(scene, workload, stratum)
                counts = study.counts.get((scene, case))
                asked = poses[:0] if counts is None else poses[~np.isnan(counts["volume_tests"][poses, 0])]
                counted = len(asked) > 0
                if mean is None and not counted:
                    continue
                row = {"scene": scene, "workload": workload, "stratum": stratum, "case": case, "mean_ns": mean}
                single = self.single_times(scene, case, workload, stratum)
                row |= {"single_poses": len(single)}
                for name, quantile in [("query_p50_ns", 0.5), ("query_p95_ns", 0.95), ("query_p99_ns", 0.99), ("query_max_ns", 1.0)]:
                    row[name] = type7(single, quantile) if len(single) else math.nan
                names = ["chunk_median_ns", "chunk_p95_ns", "chunk_max_ns"]
                if mean:
                    times, count = study.times[scene, case][chunks], study.chunks_of(scene).poses.to_numpy()[chunks]
                    timed = ~np.isnan(times).all(axis=1)
                    each, count = np.nanmean(times[timed], axis=1) / count[timed], count[timed]
                    row |= {"poses": int(count.sum()), "clusters": mean.clusters, "least": each.min()}
                    count = count * study.weights(scene, workload, stratum, self.numbers(scene, chunks), timed)[timed, 0]
                    row |= zip(names, (weighted(each, count, q) for q in (0.5, 0.95, 1.0)))
                else:
                    row |= {"poses": 0, "clusters": 0, "least": math.nan} | dict.fromkeys(names, math.nan)
                weights = study.weights(scene, workload, stratum, self.numbers(scene, asked, "poses"), slice(None))
                for name in ["volume_tests", "triangle_tests"]:
                    row[name] = (weights * counts[name][asked]).sum() / weights.sum() if counted else math.nan
                contacts, missed, interval, _, _ = self.misses(scene, case, workload)
                row |= {"contacts": contacts, "missed": missed}
                row |= {"miss_rate_low": interval[0], "miss_rate_high": interval[1]}
                yield row

    # Ratios

    def comparisons(self, scene):
        """The pairs of cases that ratios.csv has of a scene."""
        study = self.study
        cases = {case for place, case in [*study.times, *study.counts, *self.builds] if place == scene}
        null = {case for case in cases if study.cases.loc[case].duplicate_of}
        pairs = {(case, below) for below in self.baselines for case in cases - null - {below}}
        for reading in study.claims.get("reading", []):
            pair = study.referred(reading["subject"]), study.referred(reading["baseline"])
            if all(pair):
                pairs.add(pair)
        pairs |= {(case, study.cases.loc[case].duplicate_of) for case in null}
        return sorted(pairs)

    def compare(self, scene, above, below, metric):
        """The ratios of two cases by one metric: (workload, stratum, Ratio)."""
        if metric in (PROGRAM_TIME, COLD):
            of = self.program_ratio if metric == PROGRAM_TIME else self.cold_ratio
            for program in [ALL, *self.programs(scene).program]:
                yield metric, program, of(scene, above, below, program)
        elif metric == "build":
            yield "-", "-", self.build_ratio(scene, above, below)
        else:
            for workload, stratum in self.study.cells(scene):
                yield workload, stratum, self.cell_ratio(scene, above, below, metric, workload, stratum)

    def cell_ratio(self, scene, above, below, metric, workload, stratum):
        """The ratio of two cases' times or counts in a cell."""
        study, (chunks, poses) = self.study, self.cell(scene, workload, stratum)
        if metric == "time":
            pair = [study.times.get((scene, case)) for case in (above, below)]
            table, of_cell, names = "chunks", chunks, ("drawn_in", "cluster")
        else:
            name = metric.replace("-", "_")
            pair = [study.counts.get((scene, case)) for case in (above, below)]
            pair = [counts and counts[name] for counts in pair]
            table, of_cell, names = "poses", poses, ("rank", "of_line")
        if any(values is None for values in pair):
            return None
        first, second = (values[of_cell] for values in pair)
        neither = np.isnan(first) | np.isnan(second)
        first, second = (np.where(neither, np.nan, values) for values in (first, second))
        if metric != "time" and not (np.nansum(first) and np.nansum(second)):
            return None
        binaries = study.binaries[scene] if metric == "time" else []
        weights = study.weights(scene, workload, stratum, self.numbers(scene, of_cell, table), ~neither.all(axis=1))
        return ratio(*(study.column(table, scene, column)[of_cell] for column in names), weights * first, weights * second, self.draws, binaries)

    def build_ratio(self, scene, above, below):
        """The ratio of two cases' construction times, of the parts that both built: over launches; of a single one blocks are drawn."""
        pair = [self.builds.get((scene, case)) for case in (above, below)]
        if any(rows is None for rows in pair):
            return None
        rows = pair[0].merge(pair[1], on=["part", "launch", "block"], suffixes=("", "_below"))
        if not self.study.binaries[scene] and rows.launch.nunique() > 1:
            sums = rows.groupby("launch")[["ns", "ns_below"]].sum()
            return over_launches(sums.ns, sums.ns_below)
        times = (rows[[name]].to_numpy(float) for name in ("ns", "ns_below"))
        place = self.study.binary_of(scene)
        drawn = rows.launch.map(place) if place else rows.block
        return ratio(np.zeros(len(rows)), drawn.to_numpy(), *times, self.draws)

    def to_fastest(self, scene, times):
        """The ratios of the ranked volumes to the fastest one of a scene that `comparisons` does not have, as rows of ratios.csv; `times` has
        the ratios to the first baseline by workload and case."""
        workload = PROGRAM_TIME if any(key[0] == PROGRAM_TIME for key in times) else min((key[0] for key in times), key=rank, default=None)
        metric = PROGRAM_TIME if workload == PROGRAM_TIME else "time"
        safe = (variant for variant, facts in self.study.variants.items() if facts["kind"] == "volume" and facts["safe"])
        ranked = [self.study.default(variant) for variant in safe if not self.any_missed(variant)]
        of = {case: times[workload, case] for case in ranked if (workload, case) in times}
        of |= {case: 1.0 for case in self.baselines[:1] if case in ranked}
        fastest, known = min(of, key=of.get, default=None), self.comparisons(scene)
        for above in of:
            if above != fastest and (above, fastest) not in known:
                cells = self.compare(scene, above, fastest, metric)
                yield from self.rows(scene, metric, above, fastest, [cell for cell in cells if cell[:2] == (workload, ALL)])

    @staticmethod
    def rows(scene, metric, above, below, cells):
        """The ratios of two cases by one metric as rows of ratios.csv."""
        for workload, stratum, found in cells:
            if found and math.isfinite(found.value):
                yield {
                    "scene": scene, "workload": workload, "stratum": stratum, "metric": metric,
                    "case": above, "below": below, "ratio": found, "clusters": found.clusters,
                }  # fmt: skip

    def ratios(self):
        """The rows of ratios.csv."""
        metrics = [PROGRAM_TIME, COLD, "time", "volume-tests", "triangle-tests", "build"]
        for scene in sorted(self.study.scenes):
            times = {}
            for (above, below), metric in itertools.product(self.comparisons(scene), metrics):
                for row in self.rows(scene, metric, above, below, self.compare(scene, above, below, metric)):
                    yield row
                    is_ranking = metric in (PROGRAM_TIME, "time") and row["workload"] != "control" and row["stratum"] == ALL
                    if is_ranking and below in self.baselines[:1]:
                        times[row["workload"], above] = row["ratio"].value
            yield from self.to_fastest(scene, times)


# The cost model


def fitted(chunks):
    """Costs of set-up, volume test and triangle test, none below 0, by least squares over relative errors; None where nothing fixes them."""
    rows = np.column_stack([np.ones(len(chunks)), chunks.volume_tests, chunks.triangle_tests]) / chunks.ns.to_numpy()[:, None]
    best = None
    for free in itertools.product([False, True], repeat=3):
        columns = [i for i in range(3) if free[i]]
        if not columns or not rows[:, columns].any(axis=0).all():
            continue
        scale = np.linalg.norm(rows[:, columns], axis=0)
        solved, _, rank, _ = np.linalg.lstsq(rows[:, columns] / scale, np.ones(len(rows)), rcond=1e-9)
        if rank < len(columns) or (solved < 0).any():
            continue
        costs = np.zeros(3)
        costs[columns] = solved / scale
        error = ((rows @ costs - 1) ** 2).sum()
        if best is None or error < best[0]:
            best = error, costs
    return best and best[1]


def costs(derivation):
    """The rows of costs.csv, cost_chunks.csv and deadlines.csv."""
    study = derivation.study
    timings = study.timings.assign(ns=study.timings.ns / study.timings.passes)
    times = timings.groupby(["scene", "case", "chunk"]).ns.median().rename("ns").reset_index()
    counts = study.queries.groupby(["scene", "case", "chunk"])
    counts = counts.agg(volume_tests=("volume_tests", "mean"), triangle_tests=("triangle_tests", "mean"), counted=("pose", "size"))
    chunks = counts.reset_index().merge(times, on=["scene", "case", "chunk"]).merge(study.chunks, on=["scene", "chunk"])
    chunks = chunks[(chunks.workload != "control") & (chunks.counted == chunks.poses)]
    chunks["ns"] /= chunks.poses
    costs, predicted, deadlines = [], [], []
    for case, rows in chunks.groupby("case"):
        row = study.cases.loc[case]
        if row.kind not in ("volume", "engine") or row.duplicate_of:
            continue
        model = fitted(rows)
        errors = []
        for scene, here in rows.groupby("scene"):
            others = rows[rows.scene != scene]
            used = fitted(others) if len(others) else model
            times = np.column_stack([np.ones(len(here)), here.volume_tests, here.triangle_tests]) @ used
            errors.extend(abs(times / here.ns - 1))
            for chunk, ns in zip(here.itertuples(), times):
                predicted.append({
                    "scene": scene, "case": case, "chunk": chunk.chunk, "stratum": chunk.stratum, "volume_tests": chunk.volume_tests,
                    "triangle_tests": chunk.triangle_tests, "measured_ns": chunk.ns, "predicted_ns": ns,
                })  # fmt: skip
        costs.append({
            "case": case, "setup_ns": model[0], "volume_test_ns": model[1], "triangle_test_ns": model[2], "chunks": len(rows),
            "error_median": type7(errors, 0.5), "error_p95": type7(errors, 0.95),
        })  # fmt: skip
        for scene in sorted(study.scenes):
            queries = derivation.queries.get((scene, case))
            if queries is None:
                continue
            ns = np.column_stack([np.ones(len(queries)), queries.volume_tests, queries.triangle_tests]) @ model
            weight = 1 / queries.groupby("stratum").pose.transform("size")
            for slowdown in (1.0, 4.0, 16.0):
                over = {f"over_{ms}_ms": weight[slowdown * ns > ms * 1e6].sum() / weight.sum() for ms in (1, 2, 4, 8)}
                p999 = weighted(slowdown * ns, weight, 0.999)
                deadlines.append({"scene": scene, "case": case, "slowdown": slowdown, "queries": len(queries), "p999_ns": p999} | over)
    return costs, predicted, deadlines


def repay(derivation):
    """The rows of repay.csv."""
    study = derivation.study
    for scene in sorted(study.scenes):
        facts = {}
        for case, row in study.cases.iterrows():
            builds = derivation.builds.get((scene, case))
            if row.kind != "volume" or not row.safe or row.duplicate_of or builds is None:
                continue
            totals = derivation.program_totals(scene, case, ALL)
            if totals is not None:
                query = totals.mean() / derivation.programs(scene).poses.sum()
            else:
                workloads = [w for w, stratum in study.cells(scene) if stratum == ALL and w != "control"]
                workload = min(workloads, key=rank)
                query = derivation.mean_time(scene, case, workload, ALL).value
            facts[case] = builds.groupby("part").ns.median().sum(), query
        if not facts:
            continue
        baseline = min(facts, key=lambda case: facts[case][0])
        least, slowest = facts[baseline]
        for case, (build, query) in facts.items():
            queries = math.ceil((build - least) / (slowest - query)) if query < slowest else math.nan
            yield {"scene": scene, "case": case, "below": baseline, "build_ns": build, "query_ns": query, "queries": queries}

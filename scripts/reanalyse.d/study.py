"""The raw rows of a run, read strictly: a missing file, column, key or number is an error that names the place."""

import functools
import json
import tomllib
import zlib

import numpy as np
import pandas as pd

STRATA = ["colliding", "near-miss", "medium", "far"]
ALL = "all"
SCHEMA = 2

# Columns by file: t is text, i an integer of 0 or more, f a number, F a number or empty. What follows `=` is the value in records that do not
# have the column.
RAW = {
    "cases.csv": "case:t variant:t label:t kind:t safe:i split:t split_axes:t leaf:i default:i asked_everywhere:i duplicate_of:t",
    "poses.csv": "scene:t pose:i pair:t workload:t program:t line:i step:i chunk:i stratum:t band:t clearance_mm:F exact:i contained:i judged:F=",
    "answers.csv": "scene:t case:t pose:i verdict:i volume_tests:i triangle_tests:i",
    "lines.csv": "scene:t workload:t pair:t line:i contacts:i sampled:i",
    "misses.csv": "scene:t case:t workload:t pair:t line:i missed:i missed_asked:i",
    "verification.csv": "scene:t workload:t pair:t variant:t split:t split_axes:t leaf:i safe:i band:t poses:i asked:i asked_exact:i"
    " asked_missed:i exact:i brute:i tree:i missed_by_volume:i missed_by_leaf:i missed:i false_positives:i",
    "exits.csv": "scene:t stratum:t variant:t split:t split_axes:t leaf:i axis:i tests:i operations:i",
    "trees.csv": "scene:t part:t variant:t split:t split_axes:t leaf:i child_ratio:f bytes:i drift_mm:f",
    "tightness.csv": "scene:t part:t variant:t split:t split_axes:t leaf:i frame:i level:i hull_mm3:f hulled_volume_mm3:f"
    " outside_corners_pct:f",
    "outlines.csv": "scene:t part:t variant:t x1_mm:f y1_mm:f z1_mm:f x2_mm:f y2_mm:f z2_mm:f",
    "builds.csv": "scene:t part:t variant:t split:t split_axes:t leaf:i binary:i=0 launch:i block:i ns:i",
    "timings.csv": "scene:t case:t binary:i=0 launch:i block:i chunk:i passes:i ns:i",
}

# Files that records from before protocol 2.1 do not have.
LATER_RAW = {"singles.csv": "scene:t case:t cache:t binary:i launch:i pose:i ns:i"}
LATER_DERIVED = {
    "variance.csv": "scene:t workload:t variant:t split:t split_axes:t leaf:i baseline:t binaries:i launches:i blocks:i value:f binary_sd:F"
    " launch_sd:F block_sd:F low:F high:F low_within:F high_within:F planned_binaries:F planned_launches:F planned_blocks:F",
}
# Names that columns had before protocol 2.1.
OLD_NAMES = {"median_ns": "chunk_median_ns", "p95_ns": "chunk_p95_ns", "max_ns": "chunk_max_ns"}

DERIVED = {
    "program_times.csv": "scene:t program:t ends_at:t queries:i variant:t split:t split_axes:t leaf:i total_ns:f total_low_ns:f total_high_ns:f"
    " baseline:t ratio:F low:F high:F",
    "summary.csv": "scene:t workload:t stratum:t variant:t split:t split_axes:t leaf:i poses:i clusters:i mean_ns:f mean_low_ns:f mean_high_ns:f"
    " single_poses:i=0 query_p50_ns:F= query_p95_ns:F= query_p99_ns:F= query_max_ns:F= chunk_median_ns:f chunk_p95_ns:f chunk_max_ns:f"
    " volume_tests:f triangle_tests:f contacts:i missed:i miss_rate_low:f miss_rate_high:f",
    "ratios.csv": "scene:t workload:t stratum:t metric:t variant:t policy:t baseline:t baseline_policy:t ratio:f low:f high:f clusters:i effect:t"
    " noisy:i",
    "claims.csv": "claim:t role:t reading:t scene:t workload:t stratum:t verdict:t effect:t measure:t value:F low:F high:F p_holm:F missed:F"
    " baseline_missed:F note:t",
    "costs.csv": "variant:t policy:t setup_ns:f volume_test_ns:f triangle_test_ns:f chunks:i error_median:f error_p95:f",
    "cost_chunks.csv": "scene:t variant:t policy:t chunk:i stratum:t volume_tests:f triangle_tests:f measured_ns:f predicted_ns:f",
    "deadlines.csv": "scene:t variant:t policy:t slowdown:f queries:i p999_ns:f over_1_ms:f over_2_ms:f over_4_ms:f over_8_ms:f",
    "repay.csv": "scene:t variant:t policy:t baseline:t baseline_policy:t build_ns:f query_ns:f queries:F",
}


class BadInput(Exception):
    """Something cannot be read, or contradicts itself: exit code 2."""


def located(path):
    """The file, or its compressed form where only that is there."""
    packed = path.with_name(path.name + ".gz")
    return packed if packed.exists() and not path.exists() else path


def read_table(path, columns, later=False):
    """A CSV, plain or compressed, with at least these columns, each of its type. One that came `later` may be missing."""
    path = located(path)
    wanted = dict(column.split(":") for column in columns.split())
    if later and not path.exists():
        return pd.DataFrame({name: pd.Series(dtype="int64" if kind == "i" else float if kind in "fF" else str) for name, kind in wanted.items()})
    try:
        table = pd.read_csv(path, dtype=str, keep_default_na=False)
    except pd.errors.EmptyDataError:
        table = pd.DataFrame(columns=[*wanted], dtype=str)  # a table without rows has no head either
    except (OSError, EOFError, zlib.error, ValueError) as error:
        raise BadInput(f"{path}: {error}") from None
    if "chunk_median_ns" in wanted and "chunk_median_ns" not in table.columns:
        table = table.rename(columns=OLD_NAMES)
    for name, kind in list(wanted.items()):
        wanted[name], has_default, default = kind.partition("=")
        if has_default and name not in table.columns:
            table[name] = default
    missing = [name for name in wanted if name not in table.columns]
    if missing:
        raise BadInput(f"{path} has no column {', '.join(missing)}")
    table = table[list(wanted)].copy()
    for name, kind in wanted.items():
        if kind == "t":
            continue
        text = table[name]
        if kind == "i":
            wrong = ~text.str.fullmatch(r"\d{1,18}")
        else:
            numbers = pd.to_numeric(text.replace({"": "NaN"}), errors="coerce")
            wrong = numbers.isna() & ~text.isin(["NaN", ""] if kind == "F" else ["NaN"])
        if wrong.any():
            row = int(np.flatnonzero(wrong)[0])
            raise BadInput(f"{path}, line {row + 2}: {name} is `{text.iloc[row]}`, not a number")
        table[name] = text.astype("int64") if kind == "i" else numbers.astype(float)
    return table


def case_name(row):
    """The name of a case by its variant and policy."""
    return row.variant if row.split == "none" else f"{row.variant}@{row.split}/{row.split_axes}/{row.leaf}"


def with_case(table):
    """Adds the column `case` where there are variant and policy."""
    if "case" not in table and "split" in table:
        table["case"] = table.variant.where(
            table.split == "none", table.variant + "@" + table.split + "/" + table.split_axes + "/" + table.leaf.astype(str)
        )
    return table


class Study:
    """The raw rows of a run, joined: `chunks`, one row each; `times` and `counts`, by scene and case; `queries`, answers with their poses."""

    def __init__(self, folder):
        self.folder = folder
        try:
            self.manifest = json.loads((folder / "manifest.json").read_text())
            if self.manifest.get("schema") != SCHEMA:
                raise BadInput(f"{folder}: the run has schema {self.manifest.get('schema')}, this script reads {SCHEMA}")
            self.claims = tomllib.loads((folder / "claims.toml").read_text())
            self.seed = self.manifest["request"]["seed"]
            self.scenes = [scene["name"] for scene in self.manifest["scenes"]]
            self.variants = {variant["id"]: variant for variant in self.manifest["variants"]}
        except (OSError, ValueError, KeyError) as error:
            raise BadInput(f"{folder}: manifest.json and claims.toml of a run are needed: {error!r}") from None
        raw = {name: with_case(read_table(folder / name, columns)) for name, columns in RAW.items()}
        raw |= {name: read_table(folder / name, columns, later=True) for name, columns in LATER_RAW.items()}
        for name, table in raw.items():
            setattr(self, name.removesuffix(".csv"), table)
        if (self.timings.ns == 0).any() or (self.timings.passes == 0).any() or (self.builds.ns == 0).any():
            raise BadInput(f"{folder}: a time of zero in timings.csv or builds.csv")
        self.cases = self.cases.set_index("case")
        for name in ["answers", "misses", "timings", "builds", "singles"]:
            unknown = set(raw[f"{name}.csv"].case) - set(self.cases.index)
            if unknown:
                raise BadInput(f"{folder}/{name}.csv: cases.csv has no case {sorted(unknown)[0]}")
        self.parts = {}
        self.binaries = self.find_binaries()
        self.poses["of_line"] = self.poses.groupby(["workload", "pair", "line"]).ngroup()
        self.poses["rank"] = self.poses.stratum.map({name: i for i, name in enumerate(STRATA)})
        self.chunks = self.find_chunks()
        self.times = self.find_times()
        self.queries = self.answers.merge(self.poses, on=["scene", "pose"], how="left", validate="many_to_one")
        if self.queries.chunk.isna().any():
            raise BadInput(f"{folder}/answers.csv: a pose that poses.csv does not have")
        if self.answers.duplicated(["scene", "case", "pose"]).any():
            raise BadInput(f"{folder}/answers.csv: a case answers twice at one pose")
        self.counts = self.find_counts()
        self.derived = {name: with_case(read_table(folder / name, columns)) for name, columns in DERIVED.items()}
        is_old = self.manifest.get("protocol") == "2.0"
        self.derived |= {name: with_case(read_table(folder / name, columns, is_old)) for name, columns in LATER_DERIVED.items()}

    def find_binaries(self):
        """Of each scene the launches of each binary; none where all launches ran the same one."""
        ran = [table[["scene", "launch", "binary"]] for table in (self.timings, self.builds, self.singles)]
        ran = pd.concat(ran).drop_duplicates()
        if ran.duplicated(["scene", "launch"]).any():
            raise BadInput(f"{self.folder}: the rows of a launch name two binaries")
        binaries = {}
        for scene, rows in ran.groupby("scene"):
            launches = [sorted(of.launch) for _, of in rows.groupby("binary")]
            binaries[scene] = launches if len(launches) > 1 else []
        return binaries

    def binary_of(self, scene):
        """The place of each launch's binary."""
        return {launch: place for place, launches in enumerate(self.binaries.get(scene, [])) for launch in launches}

    def policy(self, case):
        """Its policy, `split/axes/leaf`."""
        row = self.cases.loc[case]
        return f"{row.split}/{row.split_axes}/{row.leaf}"

    def default(self, variant):
        """The case of a variant under its default policy; None when the run does not have it."""
        cases = self.cases[(self.cases.variant == variant) & (self.cases.default == 1)]
        return cases.index[0] if len(cases) else None

    def referred(self, reference):
        """The case that a reading names."""
        if "policy" not in reference:
            return self.default(reference["variant"])
        case = f"{reference['variant']}@{reference['policy']}"
        return case if case in self.cases.index else None

    def find_chunks(self):
        """Workload, program, stratum, number of poses and cluster of each chunk. Chunks with a line in common have the same cluster; whole
        programs have their own."""
        grouped = self.poses.groupby(["scene", "chunk"], sort=True)
        chunks = grouped.agg(
            workload=("workload", "first"),
            pair=("pair", "first"),
            judged=("judged", "first"),
            program=("program", "first"),
            stratum=("stratum", "first"),
            poses=("pose", "size"),
            ends_in_contact=("exact", "last"),
        ).reset_index()
        mixed = grouped[["workload", "program"]].nunique().max(axis=1) > 1
        mixed |= (grouped["stratum"].nunique() > 1) & (grouped["workload"].first() != "program-time")
        if mixed.any():
            raise BadInput(f"{self.folder}/poses.csv: chunk {mixed.index[mixed][0]} has poses of different kinds")
        cluster = {}
        for (scene, workload, _pair, _line), rows in self.poses.groupby(["scene", "workload", "pair", "line"]):
            if workload == "program-time":
                continue
            together = set(rows.chunk)
            known = {cluster.get((scene, chunk), chunk) for chunk in together}
            for key, value in list(cluster.items()):
                if key[0] == scene and value in known:
                    cluster[key] = min(known)
            cluster.update({(scene, chunk): min(known) for chunk in together})
        keys = list(zip(chunks.scene, chunks.chunk))
        chunks["cluster"] = [cluster.get(key, key[1]) for key in keys]
        spans = chunks.groupby(["scene", "cluster"]).stratum.nunique() > 1
        rank = chunks.stratum.map({name: i for i, name in enumerate(STRATA)})
        chunks["drawn_in"] = rank.where(~spans.loc[list(zip(chunks.scene, chunks.cluster))].to_numpy(), len(STRATA))
        return chunks

    def find_times(self):
        """Of each scene and case a matrix, chunks by launches: the median over blocks of the time of one pass, ns; NaN where it was not timed."""
        timings = self.timings.assign(ns=self.timings.ns / self.timings.passes)
        if timings.duplicated(["scene", "case", "launch", "block", "chunk"]).any():
            raise BadInput(f"{self.folder}/timings.csv: a chunk is timed twice in one block")
        if len(timings[["scene", "chunk"]].drop_duplicates().merge(self.chunks)) < len(timings[["scene", "chunk"]].drop_duplicates()):
            raise BadInput(f"{self.folder}/timings.csv: a chunk that poses.csv does not have")
        medians = timings.groupby(["scene", "case", "chunk", "launch"]).ns.median()
        times = {}
        for scene, of_scene in medians.groupby(level=0):
            rows = self.chunks_of(scene).chunk
            launches = range(int(of_scene.index.get_level_values("launch").max()) + 1)
            for case, of_case in of_scene.groupby(level=1):
                matrix = of_case.droplevel([0, 1]).unstack("launch")
                times[scene, case] = matrix.reindex(index=rows, columns=launches).to_numpy()
        return times

    def find_counts(self):
        """Of each scene and case volume tests and triangle tests, a column by pose of the scene; NaN where it was not asked."""
        counts = {}
        for scene, of_scene in self.answers.groupby("scene"):
            poses = self.poses_of(scene).pose
            for case, rows in of_scene.groupby("case"):
                rows = rows.set_index("pose")[["volume_tests", "triangle_tests"]].reindex(poses)
                counts[scene, case] = {name: rows[[name]].to_numpy() for name in rows}
        return counts

    def chunks_of(self, scene):
        """The chunks of a scene, by number."""
        return self.by_scene("chunks", scene)

    def poses_of(self, scene):
        """The poses of a scene, by number, with their line as a number."""
        return self.by_scene("poses", scene)

    @functools.cache
    def column(self, name, scene, column):
        """A column of chunks or poses of a scene."""
        return self.by_scene(name, scene)[column].to_numpy()

    def by_scene(self, name, scene):
        """The part of a table that is about a scene; each is made once."""
        if (name, scene) not in self.parts:
            table = getattr(self, name)
            self.parts[name, scene] = table[table.scene == scene].sort_values(name[:-1]).reset_index(drop=True)
        return self.parts[name, scene]

    def weights(self, scene, workload, stratum, numbers, seen):
        """A column: what the items of a cell, given by the numbers of their chunks, count in sums over those `seen`. In `recorded` as a whole an item
        counts the judged poses of its pair and stratum over the timed ones; elsewhere 1."""
        chunks = self.chunks_of(scene).set_index("chunk")
        weight = pd.Series(1.0, chunks.index)
        if workload == "recorded" and stratum == ALL:
            here = chunks.loc[np.unique(numbers[seen])]
            weight.update(here.judged / here.groupby(["pair", "stratum"]).poses.transform("sum"))
        return weight.loc[numbers].to_numpy()[:, None]

    @functools.cache
    def cells(self, scene):
        """Workload and stratum of every row that summaries and ratios have; whole programs are apart."""
        chunks = self.chunks[(self.chunks.scene == scene) & (self.chunks.workload != "program-time")]
        cells = []
        for workload in sorted(set(chunks.workload)):
            here = set(chunks[chunks.workload == workload].stratum)
            cells += [(workload, stratum) for stratum in [ALL, *STRATA] if stratum == ALL or stratum in here]
        return cells


def in_cell(table, workload, stratum):
    """Which rows of a table are in a cell."""
    inside = (table.workload == workload).to_numpy()
    return inside if stratum == ALL else inside & (table.stratum == stratum).to_numpy()

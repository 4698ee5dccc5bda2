"""A record of `bvbench peers run`: its tables, and the checks of a submission."""

import csv
import json
import math
import tomllib
from collections import defaultdict

REFERENCE = "obb-area"
SCENES = ["lathe-toolpost", "lathe-tailstock"]
POSES = 1024
# Columns of an answer that hold 0 or 1, and those that are about the pose and not about the engine.
FLAGS = ["exact", "grazing", "touching"]
TRUTH = ["exact", "grazing", "stratum", "chunk"]
# Columns of each table that are read.
COLUMNS = {
    "peers.csv": ["engine", "scene", "stratum", "mode", "poses", "mean_ns", "false_negatives", "false_positives"],
    "peer-ratios.csv": ["engine", "reference", "scene", "stratum", "mode", "ratio", "low", "high"],
    "peer-answers.csv": ["engine", "scene", "pair", "mode", "pose", *TRUTH, "touching"],
}
TEXTS = ["name", "version", "source", "licence", "method"]


class Fault(Exception):
    """What is wrong with a record: one line."""


def rows(folder, name):
    """The rows of a table about mode `first`; all have the columns that are read."""
    path = folder / name
    if not path.is_file():
        raise Fault(f"{path} is missing")
    try:
        with open(path, newline="", encoding="utf-8") as file:
            found = list(csv.DictReader(file))
    except (OSError, ValueError, csv.Error) as error:
        raise Fault(f"{path}: {error}") from None
    for number, row in enumerate(found, 1):
        if lacking := [column for column in COLUMNS[name] if row.get(column) is None]:
            raise Fault(f"{path}: row {number} lacks {', '.join(lacking)}")
    return [row for row in found if row["mode"] == "first"]


def positive(row, name, place):
    """A time or a ratio."""
    try:
        value = float(row[name])
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise Fault(f"{place}: `{name}` is {row[name]!r}, not a number above 0")
    return value


def count(row, name, place):
    if not (row[name].isdecimal() and row[name].isascii() and len(row[name]) < 16):
        raise Fault(f"{place}: `{name}` is {row[name]!r}, not a count")
    return int(row[name])


def interval(row, place):
    """A ratio and the ends of its interval, which are `None` where there is a single chunk."""
    if row["low"] == row["high"] == "NaN":
        return {"ratio": positive(row, "ratio", place), "low": None, "high": None}
    found = {name: positive(row, name, place) for name in ("ratio", "low", "high")}
    if not found["low"] <= found["ratio"] <= found["high"]:
        raise Fault(f"{place}: the ratio {found['ratio']} is not in its interval, {found['low']} to {found['high']}")
    return found


class Record:
    """The answers to mode `first` in a folder; with `submission.toml` a submission, which is about one engine."""

    def __init__(self, folder):
        self.folder = folder
        path = folder / "peers-first.json"
        if not path.is_file():
            raise Fault(f"{path} is missing: run `bvbench peers run --mode first --out {folder}`")
        try:
            self.cpu = json.loads(path.read_text(encoding="utf-8"))["machine"]["cpu"]
            toml = folder / "submission.toml"
            self.submission = tomllib.loads(toml.read_text(encoding="utf-8")) if toml.is_file() else None
        except (OSError, ValueError, RecursionError) as error:
            raise Fault(f"{folder}: {error}") from None
        except (KeyError, TypeError):
            self.cpu = None
        if not isinstance(self.cpu, str):
            raise Fault(f"{path} does not name the machine's cpu")
        self.peers = rows(folder, "peers.csv")
        self.ratios = [row for row in rows(folder, "peer-ratios.csv") if row["reference"] == REFERENCE]

    def entries(self):
        """The rows of the page: engine, scene, ratio, wrong answers. A record without the ratio to the reference has that of the means, without an interval."""
        whole = {(row["engine"], row["scene"]): row for row in self.peers if row["stratum"] == "all"}
        told = {(row["engine"], row["scene"]): row for row in self.ratios if row["stratum"] == "all"}
        asked = self.submission["engine"] if self.submission else None
        for (engine, scene), peer in whole.items():
            reference = whole.get((REFERENCE, scene))
            if reference is None or (asked and engine != asked):
                continue
            place = f"{self.folder}/peers.csv, {engine} on {scene}"
            means = [positive(row, "mean_ns", place) for row in (reference, peer)]
            if row := told.get((engine, scene)):
                ratio = interval(row, f"{self.folder}/peer-ratios.csv, {engine} on {scene}")
            else:
                ratio = {"ratio": positive({"ratio": means[0] / means[1]}, "ratio", place), "low": None, "high": None}
            yield {
                "engine": engine, "scene": scene, "cpu": self.cpu, "folder": self.folder.resolve(), "submission": self.submission, **ratio,
                "missed": count(peer, "false_negatives", place), "invented": count(peer, "false_positives", place), "poses": count(peer, "poses", place),
            }  # fmt: skip

    def check(self):
        """Raises the first fault of a submission."""
        folder, told = self.folder, self.submission
        if told is None:
            raise Fault(f"{folder}/submission.toml is missing")
        for name in [*TEXTS, "engine"]:
            if not isinstance(told.get(name), str) or not told[name].strip():
                raise Fault(f"{folder}/submission.toml: `{name}` is missing or empty")
        engine = told["engine"]
        for name in (engine, REFERENCE):
            if not any(row["engine"] == name for row in self.peers):
                raise Fault(f"{folder}/peers.csv: {name} was not run; both must be in one record")
        of = defaultdict(dict)
        for row in rows(folder, "peer-answers.csv"):
            of[row["engine"], row["scene"]][row["pair"], row["pose"]] = row
        for scene in SCENES:
            mine, reference = of[engine, scene], of[REFERENCE, scene]
            if len(mine) < POSES:
                raise Fault(f"{folder}/peer-answers.csv: {len(mine)} poses of {scene}, {POSES} at least are needed")
            if mine.keys() != reference.keys():
                raise Fault(f"{folder}/peer-answers.csv: {engine} and {REFERENCE} answered different poses of {scene}")
            for row in (*mine.values(), *reference.values()):
                for name in FLAGS:
                    if row[name] not in ("0", "1"):
                        raise Fault(f"{folder}/peer-answers.csv, {row['engine']} on {scene}, pose {row['pose']}: `{name}` is {row[name]!r}, not 0 or 1")
            if any(mine[key][name] != reference[key][name] for key in mine for name in TRUTH):
                raise Fault(f"{folder}/peer-answers.csv: the truth of a pose of {scene} differs between two engines")
            self.recount(engine, scene, mine.values())
            self.recount(REFERENCE, scene, reference.values())
            if any(row["touching"] != row["exact"] for row in reference.values() if row["grazing"] == "0"):
                raise Fault(f"{folder}/peer-answers.csv: {REFERENCE} is wrong on {scene}: the record was changed, or the build is broken")
            ratios = [row for row in self.ratios if (row["engine"], row["scene"], row["stratum"]) == (engine, scene, "all")]
            if len(ratios) != 1 or interval(ratios[0], f"{folder}/peer-ratios.csv, {engine} on {scene}")["low"] is None:
                raise Fault(f"{folder}/peer-ratios.csv does not hold one ratio of {engine} to {REFERENCE} on {scene} with its interval: run with --against {REFERENCE}")

    def recount(self, engine, scene, answers):
        """The wrong answers that `peers.csv` tells are those of the raw rows."""
        judged = [row for row in answers if row["grazing"] == "0"]
        missed = sum(row["exact"] == "1" and row["touching"] != "1" for row in judged)
        invented = sum(row["exact"] == "0" and row["touching"] == "1" for row in judged)
        told = [row for row in self.peers if (row["engine"], row["scene"], row["stratum"]) == (engine, scene, "all")]
        place = f"{self.folder}/peers.csv, {engine} on {scene}"
        if [tuple(count(row, name, place) for name in ("false_negatives", "false_positives")) for row in told] != [(missed, invented)]:
            raise Fault(f"{self.folder}/peers.csv does not tell the {missed} missed and {invented} invented contacts of {engine} on {scene} that peer-answers.csv holds")

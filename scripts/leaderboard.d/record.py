"""A record of `bvbench peers run`: its tables, and the checks of a submission."""

import csv
import json
import tomllib
from collections import defaultdict

REFERENCE = "obb-area"
SCENES = ["lathe-toolpost", "lathe-tailstock"]
POSES = 1024
# Columns of an answer that hold 0 or 1, and those that are about the pose and not about the engine.
FLAGS = ["exact", "grazing", "touching"]
TRUTH = ["exact", "grazing", "stratum", "chunk"]
TEXTS = ["name", "version", "source", "licence", "method"]


class Fault(Exception):
    """What is wrong with a record: one line."""


def rows(folder, name):
    path = folder / name
    if not path.is_file():
        raise Fault(f"{path} is missing")
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def number(row, name, place):
    try:
        return float(row[name])
    except (KeyError, TypeError, ValueError):
        raise Fault(f"{place}: `{name}` is no number: {row.get(name)!r}") from None


class Record:
    """The answers to mode `first` in a folder; with `submission.toml` a submission, which is about one engine."""

    def __init__(self, folder):
        self.folder = folder
        path = folder / "peers-first.json"
        if not path.is_file():
            raise Fault(f"{path} is missing: run `bvbench peers run --mode first --out {folder}`")
        try:
            self.run = json.loads(path.read_text(encoding="utf-8"))
            toml = folder / "submission.toml"
            self.submission = tomllib.loads(toml.read_text(encoding="utf-8")) if toml.is_file() else None
        except ValueError as error:
            raise Fault(f"{folder}: {error}") from None
        self.peers = [row for row in rows(folder, "peers.csv") if row["mode"] == "first"]
        self.ratios = [row for row in rows(folder, "peer-ratios.csv") if row["mode"] == "first" and row["reference"] == REFERENCE]

    def cpu(self):
        return self.run["machine"]["cpu"]

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
            interval = {"ratio": number(reference, "mean_ns", place) / number(peer, "mean_ns", place), "low": None, "high": None}
            if row := told.get((engine, scene)):
                interval = {name: number(row, name, f"{self.folder}/peer-ratios.csv, {engine} on {scene}") for name in interval}
                # A single chunk has no interval.
                interval = {name: None if value != value and name != "ratio" else value for name, value in interval.items()}
            yield {
                "engine": engine, "scene": scene, "cpu": self.cpu(), "folder": self.folder.resolve(), "submission": self.submission, **interval,
                "missed": int(peer["false_negatives"]), "invented": int(peer["false_positives"]), "poses": int(peer["poses"]),
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
        answers = [row for row in rows(folder, "peer-answers.csv") if row["mode"] == "first"]
        of = defaultdict(dict)
        for row in answers:
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
        if not any(row["engine"] == engine for row in self.ratios):
            raise Fault(f"{folder}/peer-ratios.csv holds no ratio of {engine} to {REFERENCE}: run with --against {REFERENCE}")

    def recount(self, engine, scene, answers):
        """The wrong answers that `peers.csv` tells are those of the raw rows."""
        judged = [row for row in answers if row["grazing"] == "0"]
        missed = sum(row["exact"] == "1" and row["touching"] != "1" for row in judged)
        invented = sum(row["exact"] == "0" and row["touching"] == "1" for row in judged)
        told = [row for row in self.peers if (row["engine"], row["scene"], row["stratum"]) == (engine, scene, "all")]
        if len(told) != 1 or (int(told[0]["false_negatives"]), int(told[0]["false_positives"])) != (missed, invented):
            raise Fault(f"{self.folder}/peers.csv does not tell the {missed} missed and {invented} invented contacts of {engine} on {scene} that peer-answers.csv holds")

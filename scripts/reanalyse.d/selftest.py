"""Each of these changes of one number must be found, and what is no number must be refused. The copies hold one scene of the study and some of its
variants, so that the test is quick: what differs because the others are missing is left out of account."""

import gzip
import json
import multiprocessing
import re
import shutil
import tempfile
from pathlib import Path

from study import DERIVED as DERIVED_TABLES
from study import LATER_DERIVED, LATER_RAW, OLD_NAMES, BadInput, located
from study import RAW as RAW_TABLES


def row_of(*words):
    """Finds the first line that has all the words as whole cells."""
    return lambda cells: set(words) <= set(cells)


def in_a_random_frame(cells):
    """Finds a root of the weighted boxes in a frame turned at random, in which the claims on tightness are judged."""
    return cells[2:8] == ["obb-area", "area-mean", "own", "1", "1", "0"]


# File, which row, column, and what becomes of the cell. A row of None is the first one.
RAW = [
    ("timings.csv", None, "ns", lambda x: str(int(x) * 2)),
    ("timings.csv", row_of("obb-area@area-mean/own/1", "2"), "passes", lambda x: str(int(x) + 1)),
    ("answers.csv", row_of("obb-area@area-mean/own/1"), "volume_tests", lambda x: str(int(x) + 1)),
    ("answers.csv", row_of("obb-vertex@vertex-mean/own/1"), "verdict", lambda x: str(1 - int(x))),
    ("lines.csv", row_of("approach"), "contacts", lambda x: str(int(x) + 1)),
    ("misses.csv", None, "missed_asked", lambda x: str(int(x) + 1)),
    ("verification.csv", row_of("over-5", "obb-area-centroid"), "missed", lambda x: str(int(x) + 1)),
    ("builds.csv", row_of("aabb"), "ns", lambda x: str(int(x) + 1)),
    ("trees.csv", row_of("obb-area-centroid", "area-mean"), "drift_mm", lambda x: str(99.0)),
    ("trees.csv", row_of("obb-area", "area-mean"), "child_ratio", lambda x: str(float(x) / 2)),
    ("tightness.csv", in_a_random_frame, "hulled_volume_mm3", lambda x: str(float(x) * 1.001)),
    ("exits.csv", row_of("aabb", "7"), "tests", lambda x: str(int(x) + 1000)),
    ("outlines.csv", row_of("obb-vertex-centroid"), "x1_mm", lambda x: str(float(x) - 50)),
]
DERIVED = [
    ("ratios.csv", row_of("time", "approach", "all", "obb-area"), "ratio", lambda x: str(float(x) * (1 + 3e-9))),
    ("program_times.csv", None, "high", lambda x: str(float(x) * 1.0001)),
    ("summary.csv", None, "chunk_p95_ns", lambda x: str(float(x) * 1.01)),
    ("claims.csv", row_of("R1", "exploratory"), "verdict", lambda x: "supported" if x != "supported" else "refuted"),
    ("deadlines.csv", None, "p999_ns", lambda x: str(float(x) * 1.01)),
]
# Ends of resampled intervals, moved by two fifths of the interval: with few binaries that is what the draws tell. These take the bootstrap.
ENDS = [("ratios.csv", row_of("time", "approach", "all", "obb-area", "obb-vertex"), "high", 0.4)]
# Of tables that records from before protocol 2.1 do not have.
LATER = [
    ("singles.csv", row_of("cold", "obb-area@area-mean/own/1"), "ns", lambda x: str(int(x) * 2)),
    ("variance.csv", row_of("program-time", "obb-area"), "value", lambda x: str(float(x) * 1.000001)),
    ("variance.csv", row_of("program-time", "obb-area"), "block_sd", lambda x: str(float(x or 0) + 0.01)),
]
BAD = [
    ("timings.csv", None, "ns", lambda x: "0"),
    ("timings.csv", None, "chunk", lambda x: "99999"),
    ("poses.csv", row_of("approach", "near-miss"), "chunk", lambda x: str(int(x) - 1)),
    ("poses.csv", None, "exact", lambda x: "yes"),
    ("answers.csv", None, "case", lambda x: "no-such-case"),
]
LATER_BAD = [
    ("timings.csv", None, "binary", lambda x: str(int(x) + 1)),
    ("singles.csv", None, "case", lambda x: "no-such-case"),
]
# Variants that no change is about.
LEFT_OUT = ["sphere-ritter", "dop-8", "obb-vertex-symmetric", "obb-area-symmetric", "obb-wide", "parry-trimesh"]


def change(path, wanted, column, edit):
    """Changes one cell; the line's number and its old and new text."""
    lines = path.read_text().splitlines(keepends=True)
    names = lines[0].rstrip("\n").split(",")
    if path.name == "summary.csv" and "chunk_p95_ns" not in names:
        names = [OLD_NAMES.get(name, name) for name in names]
    for place, line in enumerate(lines[1:], 1):
        cells = line.rstrip("\n").split(",")
        if len(cells) == len(names) and (wanted is None or wanted(cells)):
            at = names.index(column)
            old, cells[at] = cells[at], edit(cells[at]) if not isinstance(edit, float) else moved(names, cells, edit)
            lines[place] = ",".join(cells) + "\n"
            path.write_text("".join(lines))
            return f"{path.name}, line {place + 1}, {column}: {old} -> {cells[at]}"
    raise BadInput(f"{path}: no row to change")


def moved(names, cells, share):
    """The upper end, higher by a share of the interval."""
    low, high = (float(cells[names.index(name)]) for name in ("low", "high"))
    return str(high + share * (high - low))


def cut(reference, folder):
    """Copies what a study has of its first scene and of the variants that are not left out."""
    folder.mkdir()
    manifest = json.loads((reference / "manifest.json").read_text())
    scenes = manifest["scenes"]
    (folder / "manifest.json").write_text(json.dumps(manifest | {"scenes": scenes[:1]}))
    shutil.copy(reference / "claims.toml", folder)
    names = "|".join(map(re.escape, [*LEFT_OUT, *(scene["name"] for scene in scenes[1:])]))
    others = re.compile(rf"(^|,)({names})(@|,|$)", re.MULTILINE)
    for table in [*RAW_TABLES, *DERIVED_TABLES, *LATER_RAW, *LATER_DERIVED]:
        path = located(reference / table)
        if table in [*LATER_RAW, *LATER_DERIVED] and not path.exists():
            continue
        text = gzip.decompress(path.read_bytes()).decode() if path.suffix == ".gz" else path.read_text()
        lines = text.splitlines(keepends=True)
        kept = [line for line in lines if not others.search(line)]
        (folder / table).write_text("".join(kept))


def trial(number):
    """Makes one change and checks the copy; whether it was found, and what to print."""
    small, before, check, trials = SHARED
    (file, wanted, column, edit), intervals, refused = trials[number]
    copy = small.parent / f"study-{number}"
    shutil.copytree(small, copy)
    told = change(copy / file, wanted, column, edit)
    try:
        found = check(copy, intervals)[0].found
        new = [text for text in found if "standard errors" in text] if intervals else [text for text in found if text not in before]
        outcome, good = f"{len(new)} differences, such as: {new[0]}" if new else "", bool(new) and not refused
    except BadInput as error:
        outcome, good = f"refused: {str(error).removeprefix(str(copy)).lstrip('/: ')}", refused
    shutil.rmtree(copy)
    return good, f"{told}\n    {outcome[:180]}"


def other_digit(readme, copy):
    """Copies the README with another digit in its first table."""
    text = readme.read_text()
    place = text.index("|", text.index("| ---", text.index("<!-- table: ")) + 4)
    digit = next(i for i in range(text.index("\n", place), len(text)) if text[i].isdigit() and text[i - 1] == ".")
    copy.write_text(text[:digit] + str((int(text[digit]) + 1) % 10) + text[digit + 1 :])


def self_test(reference, readme, check):
    """0 when every change is found."""
    global SHARED  # what the trials' processes inherit
    workplace = Path(tempfile.mkdtemp())
    small = workplace / "small"
    cut(reference, small)
    before = set(check(small, False, readme)[0].found)
    later = (small / "variance.csv").exists()
    kinds = [(RAW + DERIVED + LATER * later, False, False), (ENDS, True, False), (BAD + LATER_BAD * later, False, True)]
    trials = [(what, intervals, refused) for changes, intervals, refused in kinds for what in changes]
    SHARED = (small, before, check, trials)
    failed = 0

    def tell(good, told):
        nonlocal failed
        print(f"{'found' if good else 'NOT FOUND'}: {told}", flush=True)
        failed += not good

    with multiprocessing.get_context("fork").Pool() as pool:
        for good, told in pool.imap(trial, range(len(trials))):
            tell(good, told)
    other_digit(readme, workplace / "README.md")
    found = [text for text in check(small, False, workplace / "README.md")[0].found if text not in before]
    tell(bool(found), f"a digit of a table of README.md\n    {(found or [''])[0][:180]}")
    shutil.rmtree(workplace)
    print(f"self-test: {failed} changes were not found" if failed else "self-test: every change was found")
    return int(failed > 0)

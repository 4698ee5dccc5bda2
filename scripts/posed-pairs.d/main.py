"""Rounds of verification over all shipped scenes, summed; `scripts/posed-pairs` says how it is called."""

import argparse
import csv
import json
import os
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

SCENES = ["lathe-toolpost", "lathe-tailstock", "trunnion-impeller", "mill-vise", "turn-mill", "robot-cell", "freeform-5axis"]
ENGINES = ["obb-wide", "aabb-wide"]
KEY = ["scene", "workload", "pair", "variant", "split", "split_axes", "leaf", "band"]
COUNTS = ["poses", "asked", "exact", "tree", "missed", "false_positives"]
ROUND = ["seed", "poses", "verdicts", "contacts", "disagreements", "twin_pairs", "twin_disagreements", "seconds"]
DISAGREEMENT = ["seed", "kind", "scene", "workload", "pair", "case", "line", "band", "missed", "false_positives"]


def fail(message):
    print(f"error: {message}", file=sys.stderr)
    sys.exit(2)


def shard(text):
    number, _, of = text.partition("/")
    if not (number.isdigit() and of.isdigit() and 1 <= int(number) <= int(of)):
        raise argparse.ArgumentTypeError(f"`{text}` is no shard: expected I/M with I from 1 to M")
    return int(number), int(of)


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/posed-pairs")
    parser.add_argument("--home", type=Path, required=True, help=argparse.SUPPRESS)
    parser.add_argument("poses", type=int, nargs="?")
    parser.add_argument("--shard", type=shard, default=(1, 1))
    parser.add_argument("--out", type=Path, default=Path("results/posed-pairs"))
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--small", action="store_true")
    parser.add_argument("--sum", type=Path, nargs="+")
    options = parser.parse_args()
    if not options.sum and not (options.poses and options.poses > 0):
        parser.error("how many posed pairs? give a number above 0")
    return options


def rows(path):
    if not path.is_file():
        return []
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def write(path, columns, table):
    partial = path.with_suffix(".partial")
    with open(partial, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n", extrasaction="ignore")
        writer.writeheader()
        writer.writerows(table)
    partial.replace(path)


def add(counts, table):
    """Adds the counts of rows to those with the same key."""
    for row in table:
        total = counts.setdefault(tuple(row[name] for name in KEY), dict.fromkeys(COUNTS, 0))
        for name in COUNTS:
            total[name] += int(row[name])


def counted(table):
    counts = {}
    add(counts, table)
    return counts


def case(row):
    return row["variant"] if row["split"] == "none" else f"{row['variant']}@{row['split']}/{row['split_axes']}/{row['leaf']}"


def disagreements(seed, run):
    """The bands and lines of a round on which an engine and the truth differ. Either verdict is right within the grazing band, and is told, too."""
    for row in rows(run / "verification.csv"):
        if int(row["missed"]) or int(row["false_positives"]):
            yield {**row, "seed": seed, "kind": "band", "case": case(row), "line": ""}
    for row in rows(run / "misses.csv"):
        yield {**row, "seed": seed, "kind": "line", "band": "", "false_positives": ""}


def one_round(program, options, seed):
    """Verifies all scenes with a seed; returns the folder of the run and the round's seconds."""
    run = options.out / "run"
    names = [word for scene in SCENES for word in ("--scene", scene)] + [word for engine in ENGINES for word in ("--variant", engine)]
    profile = "smoke" if options.small else "full"
    command = [*program, "stage", "verify", "--profile", profile, "--seed", str(seed), *names, "--quiet", "--json", "--out", str(run), "--cache", str(options.out / "cache")]
    begun = time.monotonic()
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1):
        fail(done.stderr.strip() or f"{shlex.join(command)} ended with {done.returncode}")
    return run, time.monotonic() - begun


def plain(run):
    """The tables of a run, unpacked where they are compressed."""
    for packed in run.glob("*.csv.gz"):
        import gzip

        packed.with_suffix("").write_bytes(gzip.decompress(packed.read_bytes()))


def note_round(options, seed, run, seconds):
    """Adds a finished round to the three tables; the list of rounds comes last, so that a round that was interrupted is told from a whole one."""
    plain(run)
    table = rows(run / "verification.csv")
    found = list(disagreements(seed, run))
    before = options.out / "counts.csv"
    done = rows(options.out / "rounds.csv")
    counts = counted(rows(before)) if done else {}
    add(counts, table)
    check = json.loads((run / "manifest.json").read_text(encoding="utf-8"))["cross_check"]
    first = table[0]["variant"] if table else ""
    of_first = [row for row in table if row["variant"] == first]
    total = {
        "seed": seed, "poses": sum(int(row["poses"]) for row in of_first), "verdicts": sum(int(row["asked"]) for row in table),
        "contacts": sum(int(row["exact"]) for row in of_first), "disagreements": len(found), "twin_pairs": check["pairs"],
        "twin_disagreements": check["disagreements"], "seconds": f"{seconds:.1f}",
    }  # fmt: skip
    write(options.out / "disagreements.csv", DISAGREEMENT, rows(options.out / "disagreements.csv") + found)
    keyed = [{**dict(zip(KEY, key, strict=True)), **values} for key, values in sorted(counts.items())]
    write(before, KEY + COUNTS, keyed)
    write(options.out / "rounds.csv", ROUND, [*done, total])
    shutil.rmtree(run)
    shutil.rmtree(options.out / "cache", ignore_errors=True)
    return total


def told(rounds):
    poses, seconds = sum(int(row["poses"]) for row in rounds), sum(float(row["seconds"]) for row in rounds)
    wrong = sum(int(row["disagreements"]) + int(row["twin_disagreements"]) for row in rounds)
    verdicts, contacts = sum(int(row["verdicts"]) for row in rounds), sum(int(row["contacts"]) for row in rounds)
    rate = poses / seconds if seconds else 0
    print(f"{poses} posed pairs ({contacts} contacts), {verdicts} verdicts of engines, {wrong} disagreements; {seconds:.0f} s, {rate:.0f} posed pairs per second")
    return wrong


def sum_up(folders):
    for folder in folders:
        if not (folder / "rounds.csv").is_file():
            fail(f"{folder} holds no rounds.csv")
    rounds = [row for folder in folders for row in rows(folder / "rounds.csv")]
    seeds = [row["seed"] for row in rounds]
    if len(set(seeds)) != len(seeds):
        fail("two shards hold the same seed")
    counts = counted(row for folder in folders for row in rows(folder / "counts.csv"))
    write(folders[0] / "counts.csv", KEY + COUNTS, [{**dict(zip(KEY, key, strict=True)), **values} for key, values in sorted(counts.items())])
    write(folders[0] / "disagreements.csv", DISAGREEMENT, [row for folder in folders for row in rows(folder / "disagreements.csv")])
    write(folders[0] / "rounds.csv", ROUND, rounds)
    return told(rounds)


def main():
    options = arguments()
    if options.sum:
        sys.exit(1 if sum_up(options.sum) else 0)
    given = os.environ.get("BVBENCH")
    manifest = str(options.home / "Cargo.toml")
    program = shlex.split(given) if given else ["cargo", "run", "--release", "--quiet", "--manifest-path", manifest, "--"]
    options.out.mkdir(parents=True, exist_ok=True)
    per_round = (2_000 if options.small else 1_000_000) * len(SCENES)
    last = options.first + max(1, -(-options.poses // per_round)) - 1
    number, of = options.shard
    done = {row["seed"] for row in rows(options.out / "rounds.csv")}
    for seed in range(options.first, last + 1):
        if (seed - options.first) % of == number - 1 and str(seed) not in done:
            run, seconds = one_round(program, options, seed)
            total = note_round(options, seed, run, seconds)
            print(f"seed {seed}: {total['poses']} posed pairs, {total['disagreements']} disagreements, {total['seconds']} s", flush=True)
    sys.exit(1 if told(rows(options.out / "rounds.csv")) else 0)


main()

"""A series of runs over revisions; `scripts/history` says how it is called."""

import argparse
import json
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd
from common import fail, policy, read, save

GATES = ["misses", "counts", "slower", "uncompared"]


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/history")
    parser.add_argument("--home", type=Path, required=True, help=argparse.SUPPRESS)
    parser.add_argument("series", type=Path)
    parser.add_argument("run", type=Path, nargs="?")
    parser.add_argument("--allow", action="append", default=[], choices=GATES)
    return parser.parse_args()


def failed_gates(home, before, after, allowed):
    """The gates at which a run fails."""
    program = shlex.split(os.environ.get("BVBENCH") or f"cargo run --release --quiet --manifest-path {shlex.quote(str(home / 'Cargo.toml'))} --")
    command = [*program, "stage", "compare", str(before), str(after), "--json", *(word for gate in allowed for word in ("--allow", gate))]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 1):
        fail(done.stderr.strip() or f"{shlex.join(command)} failed")
    return json.loads(done.stdout)["failed"]


def entries(series):
    """The folders of the runs in order, with the gates at which each failed."""
    index = series / "index.json"
    return json.loads(index.read_text(encoding="utf-8")) if index.is_file() else []


def add(options):
    """Adds a run; returns the gates at which it fails."""
    run = read(options.run)
    known = entries(options.series)
    passed = [entry["folder"] for entry in known if not entry["failed"]]
    failed = failed_gates(options.home, options.series / "runs" / passed[-1], options.run, options.allow) if passed else []
    revision = run.manifest["program"]["git_revision"][:12] or "unknown"
    folder = f"{len(known) + 1:04}-{revision}"
    shutil.copytree(options.run, options.series / "runs" / folder, ignore=shutil.ignore_patterns("plots", "units", ".lock", "report.*"))
    known.append({"folder": folder, "revision": revision, "failed": failed})
    text = json.dumps(known, indent=2) + "\n"
    (options.series / "index.partial").write_text(text, encoding="utf-8")
    (options.series / "index.partial").replace(options.series / "index.json")
    return failed


def rows(number, entry, folder):
    """One row per scene and case: operations of all counted queries, misses, and the programs' time."""
    run = read(folder)
    answers = run.table("answers").groupby(["scene", "case"], observed=True)[["volume_tests", "triangle_tests"]].sum()
    columns = ["scene", "case", "missed"]
    # A run without misses has an empty table, which has no columns either.
    plain = folder / "misses.csv"
    is_empty = plain.is_file() and not plain.stat().st_size
    missed = pd.DataFrame(columns=columns) if is_empty else run.table("misses")[columns]
    misses = missed.groupby(["scene", "case"], observed=True)["missed"].sum()
    table = answers.join(misses.rename("missed"), how="left").fillna({"missed": 0}).reset_index()
    times = run.table("program_times").query("program == 'all'")
    times = times.assign(case=[v if s == "none" else f"{v}@{p}" for v, s, p in zip(times["variant"], times["split"], policy(times), strict=True)])
    table = table.merge(times[["scene", "case", "total_ns", "total_low_ns", "total_high_ns"]], on=["scene", "case"], how="left")
    table.insert(0, "failed", "+".join(entry["failed"]))
    table.insert(0, "revision", entry["revision"])
    table.insert(0, "number", number)
    return table


def draw(series, table):
    """Time of the programs and tests of all queries over the runs, each as a ratio to the first run; a panel per scene."""
    scenes = sorted(table["scene"].unique())
    default = table[table["total_ns"].notna()]
    figure, axes = plt.subplots(2, len(scenes), sharex=True, squeeze=False, figsize=(4 * len(scenes), 5), layout="constrained")
    for column, scene in enumerate(scenes):
        for case, of_case in default[default["scene"] == scene].groupby("case", observed=True):
            first = of_case.iloc[0]
            axes[0][column].plot(of_case["number"], of_case["total_ns"] / first["total_ns"], marker="o", label=case)
            axes[1][column].plot(of_case["number"], of_case["volume_tests"] / max(first["volume_tests"], 1), marker="o")
        for number in of_numbers(table, scene):
            for axis in axes[:, column]:
                axis.axvline(number, color="tab:red", linestyle=":")
        axes[0][column].set_title(scene)
        axes[1][column].set_xlabel("run")
    axes[0][0].set_ylabel("program time, first run = 1")
    axes[1][0].set_ylabel("volume tests, first run = 1")
    axes[0][-1].legend(fontsize=6)
    save(figure, series / "series.svg")


def of_numbers(table, scene):
    """The runs that failed at a gate."""
    return sorted(table[(table["scene"] == scene) & (table["failed"] != "")]["number"].unique())


def main():
    options = arguments()
    failed = add(options) if options.run else []
    known = entries(options.series)
    if not known:
        fail(f"{options.series} holds no run: give one")
    table = pd.concat([rows(number, entry, options.series / "runs" / entry["folder"]) for number, entry in enumerate(known, 1)])
    table.to_csv(options.series / "series.csv", index=False, lineterminator="\n")
    draw(options.series, table)
    print(f"{len(known)} runs: {options.series / 'series.csv'}, {options.series / 'series.svg'}")
    if failed:
        print(f"The last run FAILS: {', '.join(failed)}")
    sys.exit(1 if failed else 0)


main()

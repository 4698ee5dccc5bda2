"""Runs the smoke profile over many scenes and puts their counts side by side; `scripts/across-scenes` says how it is called."""

import argparse
import os
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import tables

SHIPPED = [
    "lathe-toolpost", "lathe-tailstock", "trunnion-impeller", "mill-vise", "turn-mill", "robot-cell", "freeform-5axis",
    "size-1e3", "size-1e4", "size-1e5", "size-1e6", "grading-1", "grading-10", "grading-100",
]  # fmt: skip
COUNTED = [
    "sphere-ritter", "aabb", "dop-8", "obb-vertex", "obb-area", "obb-vertex-centroid", "obb-area-centroid", "obb-wide", "aabb-wide", "sphere-wide",
]  # fmt: skip


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/across-scenes", usage="scripts/across-scenes [--out DIR] [--safe] [--limit MINUTES] [--tables] [SCENE]...", add_help=False)
    parser.add_argument("--home", type=Path, required=True)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--safe", action="store_true")
    parser.add_argument("--limit", type=float, default=20.0)
    parser.add_argument("--tables", action="store_true")
    parser.add_argument("scenes", nargs="*")
    options = parser.parse_args()
    options.out = (options.out or options.home / "results" / "across-scenes").resolve()
    if not options.scenes:
        fetched = sorted(path.parent for path in (options.home / "target/real-scenes").glob("*/scene.toml"))
        options.scenes = [*(str(path) for path in fetched), *SHIPPED]
    return options


def program(home):
    given = os.environ.get("BVBENCH")
    if given:
        return shlex.split(given)
    return ["cargo", "run", "--release", "--all-features", "--quiet", "--manifest-path", str(home / "Cargo.toml"), "--"]


def run(command, minutes):
    """Runs one stage; true when it succeeded in time. Exit code 1 is a miss by a safe variant, which the tables show."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True)
    try:
        why = process.communicate(timeout=60 * minutes)[1].strip().splitlines()
    except subprocess.TimeoutExpired:
        why = [f"stopped after {minutes:g} minutes"]
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    if process.returncode not in (0, 1):
        print(f"{shlex.join(command)}: {(why or ['failed'])[-1]}", file=sys.stderr)
    return process.returncode in (0, 1)


def main():
    options = arguments()
    base = options.out / ("safe" if options.safe else "runs")
    variants = [word for variant in (["all"] if options.safe else COUNTED) for word in ("--variant", variant)]
    failed = []
    # All scenes are verified before any is counted: a miss is known as early as it can be.
    for stage in [] if options.tables else ["verify"] if options.safe else ["verify", "measure"]:
        for scene in options.scenes:
            name = Path(scene).name
            if name in failed:
                continue
            print(f"{stage} {name}", file=sys.stderr, flush=True)
            request = ["--scene", scene, "--profile", "smoke", "--quiet", "--out", str(base / name), "--cache", str(options.out / "truth")]
            if not run([*program(options.home), "stage", stage, *request, *variants], options.limit):
                failed.append(name)
    folders = [base / Path(scene).name for scene in options.scenes if (base / Path(scene).name / "verification.csv").is_file()]
    misses = [miss for folder in folders for miss in tables.safe_misses(folder)]
    if not options.safe and folders:
        tables.write(folders, set(SHIPPED), options.out)
    for miss in misses:
        print(f"a safe variant misses: {miss}", file=sys.stderr)
    for name in failed:
        print(f"not run: {name}", file=sys.stderr)
    print(f"{len(folders)} scenes, {len(misses)} misses of safe variants above grazing, {len(failed)} scenes not run")
    return 1 if misses or failed else 0


if __name__ == "__main__":
    sys.exit(main())

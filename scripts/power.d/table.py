"""The table of scripts/power from the ratios.csv of its studies."""

import csv
import json
import sys
from pathlib import Path


def rows_of(folder):
    """The rows of a study by (metric, variant, baseline), of all programs together."""
    with (folder / "ratios.csv").open() as file:
        return {(row["metric"], row["variant"], row["baseline"]): row for row in csv.DictReader(file) if row["stratum"] == "all"}


def shown(row):
    """Ratio with its interval."""
    return f"{float(row['ratio']):.4f} [{float(row['low']):.4f}, {float(row['high']):.4f}]"


def without_one(row):
    """Whether 1 is not in the interval."""
    return float(row["low"]) > 1 or float(row["high"]) < 1


def main():
    """The command."""
    out, scene, studies = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    found = false = excluded = noisy = 0
    print("| study | null duplicate | effect | planted 3 % | found |")
    print("| ---: | --- | --- | --- | --- |")
    for study in range(1, studies + 1):
        folder = out / f"{scene}-{study}"
        try:
            rows = rows_of(folder)
            null = rows["program-time", "null-duplicate", "obb-area"]
            planted = rows["program-time", "obb-area-slow", "obb-area-asked"]
        except (OSError, KeyError) as error:
            print(f"scripts/power: {folder} holds no study: {error!r}", file=sys.stderr)
            return 2
        is_found = float(planted["low"]) > 1
        found += is_found
        false += null["effect"] in ("less", "more")
        excluded += without_one(null)
        noisy += int(null["noisy"])
        print(f"| {study} | {shown(null)} | {null['effect']} | {shown(planted)} | {'yes' if is_found else 'no'} |")
    request = json.loads((out / f"{scene}-1" / "manifest.json").read_text())["request"]
    shape = f"{request['binaries']} binaries, {request['launches'] // request['binaries']} launches of each, {request['blocks']} blocks"
    print(
        f"\n{studies} studies of {scene} ({shape}): planted effect found in {found}; null duplicate `less` or `more` in {false}, its interval "
        f"without 1 in {excluded}, its cell noisy in {noisy}"
    )
    enough, few = found >= 0.9 * studies, false <= max(1, studies // 20)
    print("power: passed" if enough and few else "power: FAILED")
    return 0 if enough and few else 1


if __name__ == "__main__":
    sys.exit(main())

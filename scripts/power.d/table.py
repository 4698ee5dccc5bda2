"""The table of scripts/power from the ratios.csv of its studies."""

import csv
import json
import sys
from math import comb
from pathlib import Path

LEVEL = 0.05  # share of 95 % intervals that are without the true ratio


def rows_of(folder):
    """The rows of a study by (metric, variant, baseline), of all programs together."""
    with (folder / "ratios.csv").open() as file:
        return {(row["metric"], row["variant"], row["baseline"]): row for row in csv.DictReader(file) if row["stratum"] == "all"}


def shown(row):
    """Ratio with its interval."""
    return f"{float(row['ratio']):.4f} [{float(row['low']):.4f}, {float(row['high']):.4f}]"


def without_one(row):
    """Whether 1 is not in the interval: by this a planted effect is found, and by this a null duplicate is a false finding."""
    return float(row["low"]) > 1 or float(row["high"]) < 1


def at_least(count, trials):
    """Probability of so many intervals without the true ratio, or more, when one in twenty is."""
    return sum(comb(trials, k) * LEVEL**k * (1 - LEVEL) ** (trials - k) for k in range(count, trials + 1))


def main():
    """The command."""
    out, scene, studies = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    found = false = named = noisy = 0
    print("| study | null duplicate | effect | false | planted 3 % | found |")
    print("| ---: | --- | --- | --- | --- | --- |")
    for study in range(1, studies + 1):
        folder = out / f"{scene}-{study}"
        try:
            rows = rows_of(folder)
            null = rows["program-time", "null-duplicate", "obb-area"]
            planted = rows["program-time", "obb-area-slow", "obb-area-asked"]
        except (OSError, KeyError) as error:
            print(f"scripts/power: {folder} holds no study: {error!r}", file=sys.stderr)
            return 2
        is_false, is_found = without_one(null), without_one(planted) and float(planted["low"]) > 1
        found += is_found
        false += is_false
        named += null["effect"] in ("less", "more")
        noisy += int(null["noisy"])
        words = ["yes" if answer else "no" for answer in (is_false, is_found)]
        print(f"| {study} | {shown(null)} | {null['effect']} | {words[0]} | {shown(planted)} | {words[1]} |")
    request = json.loads((out / f"{scene}-1" / "manifest.json").read_text())["request"]
    shape = f"{request['binaries']} binaries, {request['launches'] // request['binaries']} launches of each, {request['blocks']} blocks"
    print(
        f"\n{studies} studies of {scene} ({shape}): planted effect found in {found}; false findings by the same criterion, the null duplicate's "
        f"interval without 1, in {false}; of these beyond 5 %, and so called `less` or `more`, {named}; its cell noisy in {noisy}"
    )
    # As many false findings as 95 % intervals have by chance, in nineteen of twenty such series.
    enough, few = found >= 0.9 * studies, at_least(false, studies) > LEVEL
    print("power: passed" if enough and few else "power: FAILED")
    return 0 if enough and few else 1


if __name__ == "__main__":
    sys.exit(main())

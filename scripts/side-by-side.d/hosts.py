"""Runs of one plan on several hosts; `scripts/across-hosts` says how it is called."""

import argparse
import math
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from common import fail, read, save
from scipy.stats import t as student

DETERMINISTIC = ["cases", "poses", "answers", "lines", "misses", "verification", "trees", "tightness", "exits"]
RATIO_KEY = ["scene", "workload", "stratum", "metric", "variant", "policy", "baseline", "baseline_policy"]
CLAIM_KEY = ["claim", "role", "reading", "scene", "workload", "stratum"]
PLAN = ["schema", "protocol", "request", "variants"]


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/across-hosts")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("runs", nargs="+", metavar="NAME=RUN")
    options = parser.parse_args()
    pairs = [run.partition("=") for run in options.runs]
    names = [name for name, _, _ in pairs]
    if any(not (name and folder) or name == "across" for name, _, folder in pairs):
        fail("a run is named as NAME=RUN, and no host is called `across`")
    if len(set(names)) != len(names) or len(names) < 2:
        fail("two hosts at least, each with a name of its own")
    options.hosts = {name: Path(folder) for name, _, folder in pairs}
    return options


def content(folder, name):
    """The bytes of a table, plain or compressed."""
    plain = folder / f"{name}.csv"
    if plain.is_file():
        return plain.read_bytes()
    import gzip

    packed = folder / f"{name}.csv.gz"
    return gzip.decompress(packed.read_bytes()) if packed.is_file() else b""


def check(hosts, runs):
    """All are of one plan and one version, and their deterministic tables are the same."""
    first = next(iter(runs))
    for name, run in runs.items():
        for key in PLAN:
            if run.manifest[key] != runs[first].manifest[key]:
                fail(f"{hosts[name]} is of another plan than {hosts[first]}: {key} differs")
        if run.manifest["program"]["version"] != runs[first].manifest["program"]["version"]:
            fail(f"{hosts[name]} is of another version than {hosts[first]}")
        differing = [table for table in DETERMINISTIC if content(hosts[name], table) != content(hosts[first], table)]
        if differing:
            fail(f"{hosts[name]} and {hosts[first]} differ where no machine may: {', '.join(differing)}", code=1)
        ours, theirs = run.manifest["inputs"], runs[first].manifest["inputs"]
        for file in sorted(file for file in ours.keys() | theirs.keys() if ours.get(file) != theirs.get(file)):
            print(f"note: {file} is another file for {name} than for {first}, with the same poses, trees and counts", file=sys.stderr)


def machines(runs):
    rows = []
    for name, run in runs.items():
        machine, program = run.manifest["machine"], run.manifest["program"]
        shown = {key: machine.get(key) for key in ("cpu", "simd", "cores", "memory_bytes", "os")}
        rows.append({"host": name, **shown, "rustc": program["rustc"], "flags": program["flags"], "noise": len(run.manifest["noise"])})
    return pd.DataFrame(rows)


def with_host(runs, table):
    frames = [run.table(table).assign(host=name) for name, run in runs.items()]
    joined = pd.concat(frames, ignore_index=True)
    return joined[["host", *(column for column in joined.columns if column != "host")]]


def ratio_across(group, hosts):
    """Geometric mean over hosts with Student's interval; nothing unless every host has it."""
    values = group["ratio"].astype(float).to_numpy()
    if len(values) != hosts or not np.all(np.isfinite(values) & (values > 0)):
        return None
    logs = np.log(values)
    half = student.ppf(0.975, hosts - 1) * logs.std(ddof=1) / math.sqrt(hosts)
    low, high = math.exp(logs.mean() - half), math.exp(logs.mean() + half)
    effect = "same" if 0.95 <= low and high <= 1.05 else "less" if high < 1 else "more" if low > 1 else "unclear"
    noisy = int(group["noisy"].astype(int).max())
    return {"ratio": math.exp(logs.mean()), "low": low, "high": high, "clusters": hosts, "effect": effect, "noisy": noisy}


def verdict_across(verdicts):
    """Supported where every host supports it, refuted where one refutes it: the protocol's rule for scenes."""
    verdicts = set(verdicts)
    if len(verdicts) == 1:
        return verdicts.pop()
    return "refuted" if "refuted" in verdicts else "undecided"


def across(table, key, summary):
    rows = []
    for values, group in table.groupby(key, sort=False, dropna=False, observed=True):
        found = summary(group)
        if found:
            rows.append({"host": "across", **dict(zip(key, values, strict=True)), **found})
    return pd.concat([table, pd.DataFrame(rows)], ignore_index=True)


def draw(ratios, hosts, path):
    """Time of whole programs over the baseline's, a panel per scene, a colour per host."""
    shown = ratios[(ratios["metric"] == "program-time") & (ratios["stratum"] == "all")]
    scenes = sorted(shown["scene"].astype(str).unique())
    shown = shown.assign(pair=[f"{v} {p} / {b} {q}" for v, p, b, q in shown[RATIO_KEY[4:]].itertuples(index=False)])
    cases = sorted(shown["pair"].unique(), reverse=True)
    # As far as the ratios go: an interval over few hosts may go much farther.
    limits = shown["ratio"].astype(float).min() / 1.5, shown["ratio"].astype(float).max() * 1.5
    figure, axes = plt.subplots(1, len(scenes), sharey=True, squeeze=False, figsize=(5 * len(scenes), 1.5 + 0.3 * len(cases)), layout="constrained")
    for axis, scene in zip(axes[0], scenes, strict=True):
        for place, host in enumerate([*hosts, "across"]):
            rows = shown[(shown["scene"] == scene) & (shown["host"] == host)]
            heights = [cases.index(pair) + 0.15 * (place - len(hosts) / 2) for pair in rows["pair"]]
            ratio, low, high = (rows[column].astype(float) for column in ("ratio", "low", "high"))
            errors = [(ratio - low).clip(lower=0).fillna(0), (high - ratio).clip(lower=0).fillna(0)]
            axis.errorbar(ratio, heights, xerr=errors, fmt="s" if host == "across" else "o", markersize=4, capsize=2, label=host)
        axis.axvline(1, color="grey", linewidth=1)
        axis.set_xscale("log")
        axis.set_xlim(*limits)
        axis.set_title(scene)
        axis.set_xlabel("program time over the baseline's")
    axes[0][0].set_yticks(range(len(cases)), cases)
    axes[0][-1].legend()
    save(figure, path)


def main():
    options = arguments()
    runs = {name: read(folder) for name, folder in options.hosts.items()}
    check(options.hosts, runs)
    options.out.mkdir(parents=True, exist_ok=True)
    ratios = across(with_host(runs, "ratios"), RATIO_KEY, lambda group: ratio_across(group, len(runs)))
    agreement = lambda group: {"verdict": verdict_across(group["verdict"]), "note": ", ".join(f"{h} {v}" for h, v in zip(group["host"], group["verdict"], strict=True))}
    claims = across(with_host(runs, "claims"), CLAIM_KEY, agreement)
    for name, table in {"hosts": machines(runs), "ratios": ratios, "claims": claims}.items():
        table.to_csv(options.out / f"{name}.csv", index=False, lineterminator="\n")
    draw(ratios, list(runs), options.out / "hosts.svg")
    primary = claims[(claims["host"] == "across") & (claims["role"] == "primary")]
    for row in primary.itertuples():
        print(f"{row.claim}: {row.verdict} ({row.note})")
    print(f"{len(runs)} hosts, the same deterministic tables: {options.out}")
    sys.exit(0)


main()

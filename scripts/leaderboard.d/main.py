"""Submissions and committed records as one page; `scripts/leaderboard` says how it is called."""

import argparse
import math
import sys
from collections import defaultdict
from html import escape
from pathlib import Path

from record import REFERENCE, SCENES, Fault, Record

STYLE = """body{font:15px/1.5 system-ui,sans-serif;max-width:70rem;margin:2rem auto;padding:0 1rem;color:#1a1a1a;background:#fff}
table{border-collapse:collapse;width:100%}th,td{padding:.3rem .6rem;text-align:right;border-bottom:1px solid #ddd}th:nth-child(-n+2),td:nth-child(-n+2){text-align:left}
.wrong{color:#b00020}a{color:inherit}@media(prefers-color-scheme:dark){body{color:#e6e6e6;background:#161616}th,td{border-color:#444}.wrong{color:#ff8a80}}"""


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/leaderboard")
    parser.add_argument("--out", type=Path, help="the page")
    parser.add_argument("--check", action="store_true", help="check submissions only")
    parser.add_argument("records", type=Path, nargs="+", metavar="RECORD")
    options = parser.parse_args()
    if bool(options.out) == options.check:
        parser.error("give --out FILE or --check")
    return options


def ranking(entries):
    """Methods of one machine, best first: those that answered all scenes, by the geometric mean of their ratios; a method that misses contacts comes after all that miss none."""
    of = defaultdict(dict)
    for entry in entries:
        if entry["scene"] in SCENES:
            of[entry["engine"], entry["folder"]][entry["scene"]] = entry
    table = []
    for (engine, folder), scenes in of.items():
        if set(scenes) == set(SCENES):
            mean = math.exp(sum(math.log(entry["ratio"]) for entry in scenes.values()) / len(SCENES))
            missed, invented = (sum(entry[name] for entry in scenes.values()) for name in ("missed", "invented"))
            table.append({"engine": engine, "folder": folder, "mean": mean, "missed": missed, "invented": invented, "scenes": scenes})
    return sorted(table, key=lambda row: (row["missed"] > 0, -row["mean"], row["engine"]))


def names(folders):
    """The end of each folder's path, as much of it as tells it from the others."""

    def end(folder, count):
        return folder.parts[-count:]

    def alone(folder, count):
        return sum(end(other, count) == end(folder, count) for other in folders) == 1

    counts = {folder: next(count for count in range(1, len(folder.parts) + 1) if alone(folder, count)) for folder in folders}
    return {folder: Path(*end(folder, count)).as_posix() for folder, count in counts.items()}


def figure(ratio):
    """A ratio with two decimals, or with two digits that are not zero."""
    return f"{ratio:.2f}" if ratio >= 0.1 else f"{ratio:.2g}"


def cell(entry):
    interval = f" <small>[{figure(entry['low'])}, {figure(entry['high'])}]</small>" if entry["low"] is not None else ""
    return f"{figure(entry['ratio'])}{interval}"


def described(submission):
    """Cell of a submitted method: name and version, linked to the source; licence and description."""
    name, source = escape(f"{submission['name']} {submission['version']}"), submission["source"]
    if source.startswith(("https://", "http://")):
        name = f'<a href="{escape(source)}">{name}</a>'
    return f"{name} <small>({escape(submission['licence'])})<br>{escape(submission['method'])}</small>"


def section(cpu, entries, called):
    head = "".join(f"<th>{escape(scene)}</th>" for scene in SCENES)
    lines = [f"<h2>{escape(cpu)}</h2><table><thead><tr><th>method</th><th>record</th>{head}<th>mean</th><th>missed</th><th>invented</th></tr></thead><tbody>"]
    for row in ranking(entries):
        submission = next(iter(row["scenes"].values()))["submission"]
        scenes = "".join(f"<td>{cell(row['scenes'][scene])}</td>" for scene in SCENES)
        wrong = "".join(f"<td{' class=wrong' if row[name] else ''}>{row[name]}</td>" for name in ("missed", "invented"))
        record = f"{escape(called[row['folder']])}{' (submission, checked)' if submission else ''}"
        lines.append(f"<tr><td>{described(submission) if submission else escape(row['engine'])}</td><td>{record}</td>{scenes}<td>{figure(row['mean'])}</td>{wrong}</tr>")
    return "\n".join([*lines, "</tbody></table>"])


def page(entries):
    machines = defaultdict(list)
    for entry in entries:
        machines[entry["cpu"]].append(entry)
    called = names({entry["folder"] for entry in entries})
    sections = "\n".join(section(cpu, machines[cpu], called) for cpu in sorted(machines))
    return f"""<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>bvbench leaderboard</title><style>{STYLE}</style></head><body>
<h1>Does it collide?</h1>
<p>How many times faster than <code>{REFERENCE}</code> a whole engine answers the same poses on the same machine, with 95 % intervals over chunks of poses where the record has the raw rows; the mean is geometric,
over the scenes. A method that misses contacts ranks below all that miss none. Times of different machines are not compared. <code>docs/leaderboard.md</code> says how to submit a method.</p>
{sections}
</body></html>
"""


def main():
    options = arguments()
    entries, failed = [], False
    for folder in options.records:
        try:
            record = Record(folder)
            if options.check or record.submission is not None:
                record.check()
            # All of a record or nothing.
            entries += list(record.entries())
            if record.submission is not None:
                print(f"{folder}: {record.submission['name']} {record.submission['version']} passes")
        except Fault as fault:
            print(f"error: {fault}", file=sys.stderr)
            failed = True
    if options.out:
        options.out.write_text(page(entries), encoding="utf-8")
        print(f"{len(entries)} rows of {len(options.records)} records: {options.out}")
    sys.exit(1 if failed else 0)


main()

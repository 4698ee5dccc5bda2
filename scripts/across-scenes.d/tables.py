"""The counts of many runs side by side: a CSV of all, and a table with what holds over the scenes."""

import csv
import math
from collections import defaultdict
from statistics import mean, median, stdev

# Two-sided 95 % quantile of Student's t by degrees of freedom; the normal one beyond.
T95 = {1: 12.706, 2: 4.303, 3: 3.182, 4: 2.776, 5: 2.571, 6: 2.447, 7: 2.365, 8: 2.306, 9: 2.262, 10: 2.228, 12: 2.179, 15: 2.131, 20: 2.086, 25: 2.060, 30: 2.042, 40: 2.021}  # fmt: skip
CASE = {"obb-area": "area-mean/own/1", "obb-area-centroid": "area-mean/own/1"}
DEFAULT_POLICY = "vertex-mean/own/1"
COLUMNS = ["scene", "origin", "workload", "case", "safe", "queries", "volume_tests", "triangle_tests", "contacts", "missed"]


def rows(path):
    if not path.is_file():
        return []
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def case(row):
    """The case of a row of verification.csv, as `cases.csv` names it: without a tree of ours the variant's id alone."""
    return row["variant"] if row["split"] == "none" else f"{row['variant']}@{row['split']}/{row['split_axes']}/{row['leaf']}"


def safe_misses(folder):
    """Each band above grazing in which a safe variant missed a contact, as text."""
    found = [row for row in rows(folder / "verification.csv") if row["safe"] == "1" and row["band"] not in ("grazing", "clear") and int(row["missed"])]
    return [f"{row['scene']} {row['workload']} {row['pair']} {case(row)}, band {row['band']}: {row['missed']} of {row['exact']}" for row in found]


def counts(folder, origin):
    """One row per workload and case: tests per query, and contacts above grazing with the misses among them."""
    poses = {(row["scene"], row["pose"]): row["workload"] for row in rows(folder / "poses.csv")}
    sums = defaultdict(lambda: [0, 0, 0])
    for row in rows(folder / "answers.csv"):
        total = sums[row["scene"], poses[row["scene"], row["pose"]], row["case"]]
        for index, value in enumerate((1, int(row["volume_tests"]), int(row["triangle_tests"]))):
            total[index] += value
    checked = defaultdict(lambda: [0, 0, "0"])
    for row in rows(folder / "verification.csv"):
        if row["band"] not in ("grazing", "clear"):
            found = checked[row["scene"], row["workload"], case(row)]
            found[0] += int(row["exact"])
            found[1] += int(row["missed"])
            found[2] = row["safe"]
    for key in sorted(set(sums) | set(checked)):
        queries, volume, triangle = sums.get(key, (0, 0, 0))
        contacts, missed, safe = checked.get(key, ("", "", ""))
        per_query = [f"{total / queries:.4f}" if queries else "" for total in (volume, triangle)]
        yield dict(zip(COLUMNS, [key[0], origin, key[1], key[2], safe, queries, *per_query, contacts, missed], strict=True))


def over_scenes(values):
    """Geometric mean with its 95 % interval over scenes, each scene one observation, as text."""
    logs = [math.log(value) for value in values]
    if len(logs) < 2:
        return f"{values[0]:.2f}" if values else "-"
    freedom = len(logs) - 1
    quantile = T95[max(known for known in T95 if known <= freedom)] if freedom <= 40 else 1.96
    half = quantile * stdev(logs) / math.sqrt(len(logs))
    low, high = math.exp(mean(logs) - half), math.exp(mean(logs) + half)
    return f"{math.exp(mean(logs)):.2f} [{low:.2f}, {high:.2f}], from {min(values):.2f} to {max(values):.2f}, below 1 in {sum(value < 1 for value in values)} of {len(values)}"


class Table:
    """The rows of scenes.csv by scene, workload and variant under its own policy."""

    def __init__(self, found):
        self.cells = {}
        for row in found:
            variant, policy = row["case"].split("@") if "@" in row["case"] else (row["case"], "")
            if policy in ("", CASE.get(variant, DEFAULT_POLICY)):
                self.cells[row["scene"], row["workload"], variant] = row
        self.lines = sorted({(row["origin"], row["scene"], row["workload"]) for row in found if row["workload"] not in ("control", "program-time")})

    def tests(self, scene, workload, variant):
        row = self.cells.get((scene, workload, variant))
        return float(row["volume_tests"]) if row and row["volume_tests"] else None

    def ratio(self, scene, workload, above, below):
        top, bottom = self.tests(scene, workload, above), self.tests(scene, workload, below)
        return top / bottom if top and bottom else None

    def missed(self, scene, workload, variant):
        row = self.cells.get((scene, workload, variant))
        return (int(row["missed"]), int(row["contacts"])) if row and row["contacts"] != "" else (0, 0)

    def shares(self, origin, workload, variant):
        """The share of the contacts of a workload that a variant misses, by scene."""
        scenes = [scene for home, scene, load in self.lines if load == workload and origin in (home, "all")]
        found = {scene: self.missed(scene, workload, variant) for scene in scenes}
        return {scene: missed / contacts for scene, (missed, contacts) in found.items() if contacts}

    def contacts(self, origin, workload):
        """Contacts above grazing of a workload over all scenes, each once."""
        return sum(self.missed(scene, load, "obb-vertex")[1] for home, scene, load in self.lines if load == workload and origin in (home, "all"))


def write(folders, shipped, out):
    """Writes scenes.csv and scenes.md."""
    found = [row for folder in folders for row in counts(folder, "shipped" if folder.name in shipped else "fetched")]
    with open(out / "scenes.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(found)
    (out / "scenes.md").write_text(markdown(Table(found)), encoding="utf-8")


def number(value, digits=2):
    return "-" if value is None else f"{value:.{digits}f}"


def markdown(table):
    lines = ["# Counts across scenes", ""]
    lines += ["Volume tests of a query and contacts above grazing that were missed; each variant under its own policy. Intervals are over scenes.", ""]
    lines += ["| origin | workload | area / plain | eight-wide / area |", "|---|---|---|---|"]
    for origin in ("fetched", "shipped", "all"):
        for workload in ("program", "recorded", "approach", "random"):
            chosen = [(scene, load) for home, scene, load in table.lines if load == workload and origin in (home, "all")]
            cells = []
            for above, below in (("obb-area", "obb-vertex"), ("obb-wide", "obb-area")):
                values = [ratio for scene, load in chosen if (ratio := table.ratio(scene, load, above, below)) is not None]
                cells.append(over_scenes(values))
            if chosen:
                lines.append(f"| {origin} | {workload} | {' | '.join(cells)} |")
    lines += ["", "Share of the contacts of a workload that the boxes as printed miss, by scene: least, median, most; the scenes on which they miss none; and those on which the area-weighted one misses less."]
    lines += ["", "| origin | workload | scenes | contacts | plain literal | none by it | area literal | none by it | area below plain |", "|---|---|---:|---:|---|---:|---|---:|---:|"]
    for origin in ("fetched", "shipped", "all"):
        for workload in ("program", "recorded", "approach", "random"):
            plain, area = (table.shares(origin, workload, variant) for variant in ("obb-vertex-centroid", "obb-area-centroid"))
            if not plain:
                continue
            spread = [f"{min(s):.1%}, {median(s):.1%}, {max(s):.1%}" for s in (list(plain.values()), list(area.values()))]
            none = [sum(share == 0 for share in shares.values()) for shares in (plain, area)]
            below = sum(area[scene] < plain[scene] for scene in plain)
            counts_of = f"| {len(plain)} | {table.contacts(origin, workload)} | {spread[0]} | {none[0]} | {spread[1]} | {none[1]} | {below} |"
            lines.append(f"| {origin} | {workload} {counts_of}")
    lines += ["", "| scene | origin | workload | plain | area / plain | AABB / plain | eight-wide | contacts | missed by plain literal | by area literal | safe misses |"]
    lines += ["|---|---|---|---:|---:|---:|---:|---:|---:|---:|---:|"]
    for origin, scene, workload in table.lines:
        contacts = table.missed(scene, workload, "obb-vertex")[1]
        safe = sum(int(row["missed"] or 0) for key, row in table.cells.items() if key[:2] == (scene, workload) and row["safe"] == "1")
        literal = [table.missed(scene, workload, variant)[0] for variant in ("obb-vertex-centroid", "obb-area-centroid")]
        lines.append(
            f"| {scene} | {origin} | {workload} | {number(table.tests(scene, workload, 'obb-vertex'), 1)} "
            f"| {number(table.ratio(scene, workload, 'obb-area', 'obb-vertex'))} | {number(table.ratio(scene, workload, 'aabb', 'obb-vertex'))} "
            f"| {number(table.tests(scene, workload, 'obb-wide'), 1)} | {contacts} | {literal[0]} | {literal[1]} | {safe} |"
        )
    return "\n".join(lines) + "\n"

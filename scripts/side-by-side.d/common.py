"""What both comparisons need: tables of a run, errors, and the look of a figure."""

import sys
from pathlib import Path

import bvbench
import matplotlib

matplotlib.use("svg")
# Text stays text, and the same data give the same file.
matplotlib.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "bvbench", "font.size": 9})

CASE = ["variant", "split", "split_axes", "leaf"]


def fail(message, code=2):
    print(f"error: {message}", file=sys.stderr)
    sys.exit(code)


def read(folder):
    """An analysed run."""
    folder = Path(folder)
    for file in ("manifest.json", "ratios.csv", "claims.csv"):
        if not (folder / file).is_file():
            fail(f"{folder} holds no {file}: run `bvbench stage analyze --out {folder}` first")
    try:
        return bvbench.Run(folder)
    except Exception as error:  # Whatever the reader says of a run that it cannot read.
        fail(f"{folder}: {error}")


def policy(table):
    """`split/axes/leaf` of every row."""
    return table["split"].astype(str) + "/" + table["split_axes"].astype(str) + "/" + table["leaf"].astype(str)


def save(figure, path):
    figure.savefig(path, metadata={"Date": None})

"""Writes figure.ipynb from figure.py, whose cells begin with `# %%`; `--check` only says whether it is up to date (exit 1 when not)."""

import json
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent


def cells(source):
    for number, part in enumerate(source.split("# %%")[1:]):
        head, _, body = part.partition("\n")
        lines = body.strip("\n").splitlines()
        cell = {"id": f"cell-{number}", "metadata": {}}
        if head.strip() == "[markdown]":
            text = [line.removeprefix("#").removeprefix(" ") for line in lines]
            yield {"cell_type": "markdown", **cell, "source": "\n".join(text).splitlines(keepends=True)}
        else:
            yield {"cell_type": "code", "execution_count": None, **cell, "outputs": [], "source": "\n".join(lines).splitlines(keepends=True)}


def notebook():
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}, "language_info": {"name": "python"}}
    content = {"cells": list(cells((HERE / "figure.py").read_text(encoding="utf-8"))), "metadata": kernel, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(content, indent=1) + "\n"


if __name__ == "__main__":
    path = HERE / "figure.ipynb"
    if sys.argv[1:] == ["--check"]:
        sys.exit(path.read_text(encoding="utf-8") != notebook())
    path.write_text(notebook(), encoding="utf-8")

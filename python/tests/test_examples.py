import os
import subprocess
import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def test_the_script_draws_the_figure(tmp_path: Path, reference: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / "figure.py"), str(reference), str(tmp_path / "figure.png")],
        capture_output=True, text=True, check=True, env={**os.environ, "MPLBACKEND": "agg"},
    )  # fmt: skip
    assert (tmp_path / "figure.png").read_bytes()[:4] == b"\x89PNG"
    assert "lathe-toolpost" in done.stdout


def test_the_notebook_is_the_script_and_runs(tmp_path: Path, reference: Path) -> None:
    subprocess.run([sys.executable, str(EXAMPLES / "make_notebook.py"), "--check"], check=True)
    notebook = nbformat.read(EXAMPLES / "figure.ipynb", as_version=4)
    nbformat.validate(notebook)
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "reference").symlink_to(reference)
    NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert (tmp_path / "figure.png").is_file()

"""`scripts/leaderboard` takes a submission whose record is whole, and refuses each way of changing one. Needs a program to make the record: BVBENCH."""

import csv
import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SCENES = ["lathe-toolpost", "lathe-tailstock"]
SUBMISSION = """engine = "obb-wide"
name = "Wide <b>"
version = "1"
source = "https://example.org/wide"
licence = "MIT"
method = "Oriented boxes, eight to a node."
"""

pytestmark = pytest.mark.skipif("BVBENCH" not in os.environ, reason="BVBENCH names no program")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("made") / "mine"
    scenes = [word for scene in SCENES for word in ("--scene", scene)]
    amount = ["--mode", "first", "--poses", "2048", "--rounds", "1"]
    engines = ["--variant", "obb-wide", "--variant", "obb-area", "--against", "obb-area"]
    subprocess.run([os.environ["BVBENCH"], "peers", "run", *scenes, *amount, *engines, "--out", folder, "--quiet"], cwd=ROOT, check=True)
    (folder / "submission.toml").write_text(SUBMISSION, encoding="utf-8")
    return folder


def leaderboard(*words: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([ROOT / "scripts" / "leaderboard", *words], capture_output=True, text=True, check=False)


def test_a_whole_record_passes_and_is_told_by_its_name(made: Path, tmp_path: Path) -> None:
    assert leaderboard("--check", made).returncode == 0
    page = tmp_path / "page.html"
    assert leaderboard("--out", page, made).returncode == 0
    text = page.read_text(encoding="utf-8")
    assert '<a href="https://example.org/wide">Wide &lt;b&gt; 1</a>' in text
    assert "Oriented boxes, eight to a node." in text


def test_records_of_the_same_name_are_told_apart(made: Path, tmp_path: Path) -> None:
    folders = [tmp_path / person / "mine" for person in ("alice", "bob")]
    for folder in folders:
        shutil.copytree(made, folder)
        path = folder / "submission.toml"
        path.write_text(path.read_text(encoding="utf-8").replace("Wide <b>", folder.parent.name.title()), encoding="utf-8")
    page = tmp_path / "page.html"
    # A record that is named twice counts once.
    assert leaderboard("--out", page, made, *folders, *folders).returncode == 0
    text = page.read_text(encoding="utf-8")
    for name, record in (("Wide &lt;b&gt; 1", f"{made.parent.name}/mine"), ("Alice 1", "alice/mine"), ("Bob 1", "bob/mine")):
        assert text.count(name) == text.count(f"<td>{record} (submission, checked)</td>") == 1


def without_licence(folder: Path) -> None:
    path = folder / "submission.toml"
    path.write_text(path.read_text(encoding="utf-8").replace('"MIT"', '""'), encoding="utf-8")


def changed(keep: Callable[[dict[str, str]], bool] = lambda row: True, table: str = "peer-answers", **values: str) -> Callable[[Path], None]:
    """Leaves only some rows of a table, and sets columns of the first one of the engine: of the answers, the first contact that it found."""

    def change(folder: Path) -> None:
        path = folder / f"{table}.csv"
        with open(path, newline="", encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(file) if keep(row)]
        next(row for row in rows if row["engine"] == "obb-wide" and row.get("grazing", "0") == "0" and row.get("touching", "1") == "1").update(values)
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)

    return change


def test_a_record_that_is_not_described_is_no_submission(made: Path, tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    shutil.copytree(made, folder)
    (folder / "submission.toml").unlink()
    refused = leaderboard("--check", folder)
    assert refused.returncode == 1
    assert "submission.toml is missing" in refused.stderr


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (without_licence, "`licence` is missing or empty"),
        (lambda folder: (folder / "peers-first.json").write_text("{}", encoding="utf-8"), "does not name the machine's cpu"),
        (changed(touching="0"), "does not tell the 1 missed"),
        (changed(exact="0"), "the truth of a pose of lathe-toolpost differs"),
        (changed(grazing="1", touching="0"), "the truth of a pose of lathe-toolpost differs"),
        (changed(touching=""), "`touching` is '', not 0 or 1"),
        (changed(lambda row: int(row["pose"]) < 300 or row["scene"] != "lathe-tailstock"), "1024 at least are needed"),
        (changed(lambda row: row["engine"] != "obb-area"), "answered different poses"),
        (changed(table="peers", false_negatives=""), "`false_negatives` is '', not a count"),
        (changed(table="peers", mean_ns="0"), "`mean_ns` is '0', not a number above 0"),
        (changed(table="peers", poses="1_0"), "`poses` is '1_0', not a count"),
        *((changed(table="peer-ratios", ratio=ratio), f"`ratio` is '{ratio}', not a number above 0") for ratio in ("0", "-1", "nan", "inf", "x")),
        (changed(table="peer-ratios", ratio="1e9"), "the ratio 1000000000.0 is not in its interval"),
        (changed(table="peer-ratios", low="NaN", high="NaN"), "does not hold one ratio of obb-wide to obb-area on lathe-toolpost"),
        (changed(lambda row: row["scene"] != "lathe-tailstock" or row["stratum"] != "all", table="peer-ratios"), "does not hold one ratio of obb-wide to obb-area on lathe-tailstock"),
    ],
)
def test_a_changed_record_is_refused_and_the_others_are_shown(made: Path, tmp_path: Path, change: Callable[[Path], None], fault: str) -> None:
    folder, page = tmp_path / "changed", tmp_path / "page.html"
    shutil.copytree(made, folder)
    change(folder)
    assert leaderboard("--check", folder).returncode == 1
    refused = leaderboard("--out", page, folder, made)
    assert refused.returncode == 1
    assert fault in refused.stderr
    assert "<td>mine (submission, checked)</td>" in page.read_text(encoding="utf-8")

import csv
import gzip
import io
import json
import shutil
from pathlib import Path

import pandas as pd
import pytest

import bvbench


def text_of(path: Path) -> io.StringIO:
    """The table's text, by nothing but the standard library."""
    raw = path.read_bytes()
    return io.StringIO((gzip.decompress(raw) if path.suffix == ".gz" else raw).decode("utf-8"), newline="")


def test_every_table_is_read_with_its_types(reference: Path) -> None:
    run = bvbench.Run(reference)
    assert {"answers", "poses", "claims", "audit/audit_cells"} <= set(run.tables())
    for name in run.tables():
        rows = list(csv.reader(text_of(run.path(name))))
        frame = run.table(name)
        assert list(frame.columns) == rows[0]
        assert len(frame) == len(rows) - 1
        for column in frame.columns:
            assert frame[column].dtype != object, (name, column)


def test_flags_and_counts_and_missing_values(reference: Path) -> None:
    run = bvbench.Run(reference)
    poses = run.table("poses")
    assert poses["exact"].dtype == bool
    rows = csv.DictReader(text_of(run.path("poses")))
    assert poses["exact"].sum() == sum(row["exact"] == "1" for row in rows)
    # The same name in another table is a count, in a third a text.
    assert run.table("verification")["exact"].max() > 1
    assert set(run.table("claims")["verdict"]) <= {"supported", "refuted", "undecided", "not-applicable", "not-judged"}
    # An empty cell is missing, the word `none` is not.
    assert run.table("claims")["missed"].isna().any()
    assert run.table("claims")["missed"].dtype == "Int64"
    assert (run.table("cases")["split"] == "none").any()
    assert run.table("cases")["duplicate_of"].isna().any()
    assert run.table("timings")["ns"].dtype == "int64"


def test_floats_are_read_to_the_last_bit(reference: Path) -> None:
    run = bvbench.Run(reference)
    expected = [float(row["ratio"]) for row in csv.DictReader(text_of(run.path("ratios")))]
    assert run.table("ratios")["ratio"].tolist() == expected


def test_polars_gives_the_same_numbers(reference: Path) -> None:
    run = bvbench.Run(reference)
    ours, theirs = run.table("summary"), run.table("summary", engine="polars")
    assert theirs["mean_ns"].sum() == pytest.approx(ours["mean_ns"].sum(), rel=1e-12)
    assert theirs.columns == list(ours.columns)


def test_a_column_that_is_not_known_yet_is_kept(tmp_path: Path, reference: Path) -> None:
    shutil.copy(reference / "manifest.json", tmp_path)
    (tmp_path / "timings.csv").write_text("scene,binary,weight,ns\nlathe,0,1.5,12\n", encoding="utf-8")
    frame = bvbench.Run(tmp_path).table("timings")
    assert frame["weight"].tolist() == [1.5]
    assert frame["binary"].tolist() == ["0"]


def test_compressed_tables_are_read(tmp_path: Path, reference: Path) -> None:
    shutil.copy(reference / "manifest.json", tmp_path)
    whole = bvbench.Run(reference).table("cases")
    whole.astype({flag: int for flag in ("safe", "default", "asked_everywhere")}).to_csv(tmp_path / "cases.csv.gz", index=False)
    run = bvbench.Run(tmp_path)
    assert run.tables() == ["cases"]
    pd.testing.assert_frame_equal(run.table("cases"), whole)


@pytest.mark.parametrize(
    ("files", "words"),
    [
        ({}, "no manifest.json"),
        ({"manifest.json": "{"}, "manifest.json:1:2: not JSON"),
        ({"manifest.json": '{"schema": 1}'}, "layout 1, this package reads layout 2"),
    ],
)
def test_what_is_no_run_is_refused(tmp_path: Path, files: dict[str, str], words: str) -> None:
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(bvbench.RunError, match=words):
        bvbench.Run(tmp_path)


def test_bad_tables_are_named(tmp_path: Path) -> None:
    (tmp_path / "manifest.json").write_text(json.dumps({"schema": 2}), encoding="utf-8")
    (tmp_path / "cases.csv").write_text("case,safe\na,1\nb,2\n", encoding="utf-8")
    (tmp_path / "answers.csv").write_text("", encoding="utf-8")
    run = bvbench.Run(tmp_path)
    with pytest.raises(bvbench.RunError, match=r"cases.csv:3: safe is .*2"):
        run.table("cases")
    with pytest.raises(bvbench.RunError, match=r"answers.csv: not a table"):
        run.table("answers")
    with pytest.raises(bvbench.RunError, match="no table poses; it has answers, cases"):
        run.table("poses")

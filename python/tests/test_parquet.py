import json
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq

import bvbench


def test_every_table_comes_back_as_it_was(tmp_path: Path, reference: Path) -> None:
    run = bvbench.Run(reference)
    written = bvbench.to_parquet(reference, tmp_path)
    assert [path.relative_to(tmp_path).with_suffix("").as_posix() for path in written] == run.tables()
    for path, name in zip(written, run.tables(), strict=True):
        pd.testing.assert_frame_equal(pd.read_parquet(path), run.table(name))
    assert not list(tmp_path.rglob("*.partial"))


def test_the_manifest_travels_along(tmp_path: Path, reference: Path) -> None:
    bvbench.to_parquet(reference, tmp_path)
    path = tmp_path / "cases.parquet"
    assert json.loads(pq.read_schema(path).metadata[b"bvbench"]) == bvbench.Run(reference).manifest
    assert str(pq.read_schema(path).field("safe").type) == "bool"

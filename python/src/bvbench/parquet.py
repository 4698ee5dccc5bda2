"""Tables of a run as Parquet."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from bvbench.run import Run

if TYPE_CHECKING:
    import os


def to_parquet(folder: str | os.PathLike[str] | Run, out: str | os.PathLike[str] | None = None) -> list[Path]:
    """Writes every table of a run as a Parquet file and returns their paths.

    `out` is the folder for the files, by default `parquet` in the run's folder. Each file carries the run's manifest under the key ``bvbench``. Existing
    files are replaced. Needs pyarrow.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    run = folder if isinstance(folder, Run) else Run(folder)
    target = Path(out) if out is not None else run.folder / "parquet"
    written = []
    for name in run.tables():
        table = pa.Table.from_pandas(run.table(name), preserve_index=False)
        table = table.replace_schema_metadata({**(table.schema.metadata or {}), b"bvbench": json.dumps(run.manifest).encode()})
        path = target / f"{name}.parquet"
        path.parent.mkdir(parents=True, exist_ok=True)
        partial = path.with_suffix(".partial")
        pq.write_table(table, partial, compression="zstd")
        partial.replace(path)
        written.append(path)
    return written

"""A run's folder: its manifest and its tables."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

import pandas as pd

from bvbench.columns import COUNTS, flag_columns, text_columns

if TYPE_CHECKING:
    import os

    import polars as pl

#: The layout of tables that this package reads: `schema` in the manifest.
SCHEMA = 2

_ENDINGS = (".csv", ".csv.gz", ".csv.zst", ".csv.xz")


class RunError(ValueError):
    """A folder is not a run, or not one that this package reads."""


class Run:
    """The folder that a run of bvbench wrote.

    Raises `RunError` when the folder has no manifest or its tables are of another layout.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)
        path = self.folder / "manifest.json"
        try:
            self.manifest: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        except FileNotFoundError as error:
            raise RunError(f"{self.folder} is not the folder of a run: it has no manifest.json") from error
        except json.JSONDecodeError as error:
            raise RunError(f"{path}:{error.lineno}:{error.colno}: not JSON: {error.msg}") from error
        schema = self.manifest.get("schema")
        if schema != SCHEMA:
            raise RunError(f"{path}: the tables are of layout {schema}, this package reads layout {SCHEMA}")

    def __repr__(self) -> str:
        return f"Run({str(self.folder)!r})"

    @property
    def protocol(self) -> str:
        """Version of the protocol by which the run measured and judged."""
        return str(self.manifest.get("protocol", ""))

    @property
    def seed(self) -> int:
        """Seed of all randomness of the run."""
        return int(self.manifest["request"]["seed"])

    @property
    def scenes(self) -> list[str]:
        """Names of the scenes, in the order in which they were run."""
        return [str(scene["name"]) for scene in self.manifest.get("scenes", [])]

    def tables(self) -> list[str]:
        """Names of the tables in the folder, without endings; those of folders in it are `folder/name`."""
        found = {path.relative_to(self.folder).as_posix() for ending in _ENDINGS for path in self.folder.rglob(f"*{ending}")}
        return sorted({name[: name.index(".csv")] for name in found if "units/" not in name})

    def path(self, table: str) -> Path:
        """File of a table, compressed or not. Raises `RunError` when there is none."""
        for ending in _ENDINGS:
            path = self.folder / f"{table}{ending}"
            if path.is_file():
                return path
        raise RunError(f"{self.folder} has no table {table}; it has {', '.join(self.tables())}")

    @overload
    def table(self, name: str, engine: Literal["pandas"] = "pandas") -> pd.DataFrame: ...
    @overload
    def table(self, name: str, engine: Literal["polars"]) -> pl.DataFrame: ...
    def table(self, name: str, engine: Literal["pandas", "polars"] = "pandas") -> pd.DataFrame | pl.DataFrame:
        """Reads a table.

        Flags become bool, whole numbers Int64 where a cell is empty, text str with NA for an empty cell. ``NaN``, the mean of nothing, stays a float.
        Raises `RunError` for a table that is not there, a file that is no table, and a flag that is neither 0 nor 1.
        """
        frame = _read(self.path(name), name.rsplit("/", 1)[-1])
        if engine == "pandas":
            return frame
        if engine == "polars":
            import polars

            return polars.from_pandas(frame)
        raise ValueError(f"engine is pandas or polars, not {engine!r}")


def _read(path: Path, table: str) -> pd.DataFrame:
    """Reads one CSV by the dictionary's types."""
    texts, flags = text_columns(table), flag_columns(table)
    try:
        header = pd.read_csv(path, nrows=0).columns
        # Empty cells alone are missing: `none`, `null` and `nan` would be names.
        empty: dict[str, list[str]] = {str(column): ["", "NaN"] if column not in texts else [""] for column in header}
        kinds = {str(column): "string" for column in header if column in texts}
        frame = pd.read_csv(path, dtype=kinds, keep_default_na=False, na_values=empty)
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
        raise RunError(f"{path}: not a table: {error}") from error
    for column in frame.columns:
        if column in flags:
            if not frame[column].isin((0, 1)).all():
                row = int((~frame[column].isin((0, 1))).to_numpy().argmax())
                raise RunError(f"{path}:{row + 2}: {column} is {frame[column].iloc[row]!r}, not 0 or 1")
            frame[column] = frame[column].astype(bool)
        elif column in COUNTS and frame[column].dtype.kind == "f" and frame[column].isna().any():
            frame[column] = frame[column].astype("Int64")
    return frame

"""Readers of bvbench's runs.

`Run` reads the tables of a run's folder as pandas or polars frames, `to_parquet` writes them as Parquet. `Pair` holds two meshes, their poses and the exact
verdicts, as ``bvbench peers export`` writes them, and goes to trimesh and back. `read_poses` and `write_poses` are for the recorded poses of a scene.
Lengths are mm, times ns; columns are described in the data dictionary of the run, ``results/README.md``.
"""

from bvbench.pair import Pair
from bvbench.parquet import to_parquet
from bvbench.poses import read_poses, write_poses
from bvbench.run import SCHEMA, Run, RunError

__all__ = ["SCHEMA", "Pair", "Run", "RunError", "read_poses", "to_parquet", "write_poses"]

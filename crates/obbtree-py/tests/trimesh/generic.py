"""What trimesh's collision tests import as `generic`: its source distribution has the tests but neither this module nor the meshes."""

import logging
import os
import pathlib
import unittest

import numpy as np
import pytest
import trimesh

log = logging.getLogger("trimesh")
random = np.random.default_rng(2011).random
__all__ = ["get_mesh", "log", "np", "random", "trimesh", "unittest"]

# A cube of edge 1 about the origin, side by side, each as a quadrilateral.
_SIDES = [
    [(-1, -1, 1), (-1, 1, 1), (-1, 1, -1), (-1, -1, -1)],
    [(1, -1, 1), (-1, -1, 1), (-1, -1, -1), (1, -1, -1)],
    [(1, 1, 1), (1, -1, 1), (1, -1, -1), (1, 1, -1)],
    [(-1, 1, 1), (1, 1, 1), (1, 1, -1), (-1, 1, -1)],
    [(1, -1, 1), (1, 1, 1), (-1, 1, 1), (-1, -1, 1)],
    [(1, 1, -1), (1, -1, -1), (-1, -1, -1), (-1, 1, -1)],
]


def get_mesh(name):
    """The mesh of that name from the folder in TRIMESH_MODELS; the unit cube without it."""
    models = os.environ.get("TRIMESH_MODELS")
    if models:
        return trimesh.load(pathlib.Path(models) / name)
    if name == "unit_cube.STL":
        triangles = [[a, b, d] for a, b, _, d in _SIDES] + [[d, b, c] for _, b, c, d in _SIDES]
        return trimesh.Trimesh(**trimesh.triangles.to_kwargs(np.array(triangles) / 2.0))
    pytest.skip(f"{name} is in trimesh's repository only; name its folder models in TRIMESH_MODELS")

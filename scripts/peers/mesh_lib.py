"""MeshLib (PyPI `meshlib`): one tree of boxes along the axes for each mesh, single precision; from Python, on one core.

Times include the calls from Python. A query about parts that are far apart takes 1.8 µs with them.
"""

import os

import meshlib.mrmeshnumpy as numpy_meshes
import meshlib.mrmeshpy as meshlib
import numpy as np
from runner import serve


class Engine:
    """Both meshes, and their trees, which MeshLib makes when they are first asked for."""

    @staticmethod
    def has(mode):
        return mode in ("first", "path", "all", "distance")

    @staticmethod
    def question(matrix):
        rows = [meshlib.Vector3f(*map(float, row[:3])) for row in matrix]
        way = meshlib.Vector3f(*(float(row[3]) for row in matrix))
        return meshlib.AffineXf3f(meshlib.Matrix3f(*rows), way)

    def __init__(self, *sides):
        self.meshes = [numpy_meshes.meshFromFacesVerts(faces.astype(np.int32), vertices) for vertices, faces in sides]
        for mesh in self.meshes:
            mesh.getAABBTree()
        self.a, self.b = map(meshlib.MeshPart, self.meshes)

    def answer(self, mode, b_in_a):
        if mode == "distance":
            return float(meshlib.findDistance(self.a, self.b, b_in_a).distSq) ** 0.5
        return len(meshlib.findCollidingTriangles(self.a, self.b, b_in_a, mode != "all"))


if __name__ == "__main__":
    # Its searches divide their work over all cores that they find.
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    serve(Engine)

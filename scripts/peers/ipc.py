"""The IPC toolkit (PyPI `ipctk`), mode `motion` only: broad phase and tight-inclusion search over vertices that go straight.

A vertex of a part that turns goes along an arc. The motion is cut so that no chord is farther than 0.0001 mm from its arc, and the pieces are searched in turn. The first
contact is the end of the step that the toolkit calls free of collision. Times include the calls from Python, some microseconds a piece.
"""

import ipctk
import numpy as np
from runner import serve

SAGITTA_MM = 1e-4
# The step goes so far towards contact; the toolkit's own 0.8 would leave a fifth of the distance.
RESCALING = 0.9999


class Engine:
    """Both meshes as one, in which vertices of one part do not meet each other."""

    # With 2 000 a motion takes seconds.
    most_triangles = 500

    @staticmethod
    def has(mode):
        return mode == "motion"

    @staticmethod
    def question(start, end):
        return start, end

    def __init__(self, a, b):
        (vertices_a, faces_a), (self.moved, faces_b) = a, b
        self.still = vertices_a
        faces = np.vstack([faces_a, faces_b + len(vertices_a)]).astype(np.int32)
        rest = np.asfortranarray(np.vstack([vertices_a, self.moved]))
        self.mesh = ipctk.CollisionMesh(rest, ipctk.edges(faces), np.asfortranarray(faces))
        parts = np.repeat([0, 1], [len(vertices_a), len(self.moved)]).astype(np.int32)
        self.mesh.can_collide = ipctk.make_vertex_patches_filter(parts)
        self.search = ipctk.TightInclusionCCD(conservative_rescaling=RESCALING)
        self.reach = np.linalg.norm(self.moved, axis=1).max()

    def at(self, start, way, axis, angle, when):
        """The vertices at a time."""
        x, y, z = axis
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turn = np.eye(3) + np.sin(angle * when) * cross + (1 - np.cos(angle * when)) * cross @ cross
        placed = self.moved @ (turn @ start[:, :3]).T + start[:, 3] + when * way
        return np.asfortranarray(np.vstack([self.still, placed]))

    def answer(self, _, question):
        start, end = question
        turn = end[:, :3] @ start[:, :3].T
        twice = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        sine = np.linalg.norm(twice)
        angle = np.arctan2(sine, np.trace(turn) - 1)
        axis = twice / sine if sine > 0 else np.zeros(3)
        way = end[:, 3] - start[:, 3]
        pieces = max(1, int(np.ceil(angle * np.sqrt(self.reach / (8 * SAGITTA_MM)))))
        before = self.at(start, way, axis, angle, 0.0)
        for piece in range(pieces):
            after = self.at(start, way, axis, angle, (piece + 1) / pieces)
            step = ipctk.compute_collision_free_stepsize(self.mesh, before, after, narrow_phase_ccd=self.search)
            if step < 1:
                return (piece + step) / pieces
            before = after
        return np.inf


if __name__ == "__main__":
    ipctk.set_num_threads(1)
    ipctk.set_logger_level(ipctk.LoggerLevel.error)
    serve(Engine)

"""The IPC toolkit (PyPI `ipctk`), mode `motion` only: broad phase and tight-inclusion search over vertices that go straight.

A vertex of a part that turns goes along an arc. The motion is cut so that no chord is farther than 0.0001 mm from its arc, and the pieces are searched in turn. The first
contact is the end of the step that the toolkit calls free of collision. Times include the calls from Python, some microseconds a piece.
"""

import sys
import time
from pathlib import Path

import ipctk
import numpy as np

SAGITTA_MM = 1e-4
SHORTEST_NS = 100_000
LONG_NS = 20_000_000
# Pairs with more are not answered: with 2 000 a motion takes seconds.
MOST_TRIANGLES = 500
# The step goes so far towards contact; the toolkit's own 0.8 would leave a fifth of the distance.
RESCALING = 0.9999


class Engine:
    """Both meshes as one, in which vertices of one part do not meet each other."""

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

    def first_contact(self, start, end):
        """The time of first contact; infinite without."""
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


class Runner:
    """The protocol of docs/adding-a-peer.md."""

    def __init__(self, pair, rounds):
        load = lambda name: np.load(pair / f"{name}.npy")
        self.meshes = [(load(f"{side}_vertices"), load(f"{side}_faces")) for side in "ab"]
        self.starts, self.ends = load("poses"), load("ends")
        count = len(self.starts)
        self.answers, self.asked = np.zeros(count), np.zeros(count, dtype=int)
        self.ns = np.zeros((rounds, count), dtype=np.uint64)
        self.engine = None

    def build(self):
        begun = time.perf_counter_ns()
        self.engine = Engine(*self.meshes)
        return time.perf_counter_ns() - begun

    def one_by_one(self, poses):
        times = []
        for i in poses:
            begun = time.perf_counter_ns()
            self.answers[i] = self.engine.first_contact(self.starts[i], self.ends[i])
            times.append(max(time.perf_counter_ns() - begun, 1))
        return times

    def chunk(self, first, end):
        poses = range(first, end)
        if self.engine is None:
            self.build()
        times = self.one_by_one(poses)
        once = total = sum(times)
        if once < LONG_NS:
            passes = max(1, -(-SHORTEST_NS // once))
            begun = time.perf_counter_ns()
            for _ in range(passes):
                for i in poses:
                    self.answers[i] = self.engine.first_contact(self.starts[i], self.ends[i])
            total = (time.perf_counter_ns() - begun) // passes
            times = self.one_by_one(poses)
        for i, ns in zip(poses, times):
            if self.asked[i] < len(self.ns):
                self.ns[self.asked[i], i] = ns
                self.asked[i] += 1
        return total

    def write(self, out):
        np.save(out / "verdicts.npy", np.isfinite(self.answers).astype(np.uint8))
        np.save(out / "values.npy", self.answers)
        np.save(out / "ns.npy", self.ns)


def main(mode, pair, out, rounds):
    if mode != "motion":
        print("unsupported", flush=True)
        return
    ipctk.set_num_threads(1)
    ipctk.set_logger_level(ipctk.LoggerLevel.error)
    runner = Runner(Path(pair), int(rounds))
    if sum(len(faces) for _, faces in runner.meshes) > MOST_TRIANGLES:
        print("unsupported", flush=True)
        return
    print("ready", flush=True)
    for line in sys.stdin:
        match line.split():
            case ["build"]:
                print("done", runner.build(), flush=True)
            case ["bytes"]:
                print("done 0", flush=True)
            case ["chunk", first, end]:
                print("done", runner.chunk(int(first), int(end)), flush=True)
            case ["quit"]:
                runner.write(Path(out))
                print("done 0", flush=True)
                return
            case _:
                sys.exit(f"unknown command {line}")


if __name__ == "__main__":
    main(*sys.argv[1:])

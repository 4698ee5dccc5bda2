"""FCL through python-fcl as a runner of `bvbench peers`: the protocol of docs/adding-a-peer.md, mode `first`.

    python runner.py MODE PAIR OUT ROUNDS
"""

import sys
import time
from pathlib import Path

import fcl
import numpy as np

SAMPLE_NS = 100_000
LONG_PASS_NS = 20_000_000


def answer_line(words):
    print(words, flush=True)


class Engine:
    def __init__(self, pair, rounds):
        load = lambda name: np.load(pair / f"{name}.npy")
        self.meshes = [(load(f"{side}_vertices"), load(f"{side}_faces")) for side in "ab"]
        self.poses = [(np.ascontiguousarray(pose[:, :3]), np.ascontiguousarray(pose[:, 3])) for pose in load("poses")]
        self.verdicts = np.zeros(len(self.poses), dtype=np.uint8)
        self.ns = np.zeros((rounds, len(self.poses)), dtype=np.uint64)
        self.asked = np.zeros(len(self.poses), dtype=int)

    def build(self):
        begun = time.perf_counter_ns()
        objects = []
        for vertices, faces in self.meshes:
            model = fcl.BVHModel()
            model.beginModel(len(vertices), len(faces))
            model.addSubModel(vertices, faces)
            model.endModel()
            objects.append(fcl.CollisionObject(model, fcl.Transform()))
        self.a, self.b = objects
        return time.perf_counter_ns() - begun

    def ask(self, pose):
        rotation, translation = self.poses[pose]
        self.b.setTransform(fcl.Transform(rotation, translation))
        self.verdicts[pose] = fcl.collide(self.a, self.b, fcl.CollisionRequest(), fcl.CollisionResult()) > 0

    def one_by_one(self, first, last):
        """A pass pose by pose; the first pass over a pose that is timed is its round 0."""
        total = 0
        for pose in range(first, last):
            begun = time.perf_counter_ns()
            self.ask(pose)
            ns = time.perf_counter_ns() - begun
            if self.asked[pose] < len(self.ns):
                self.ns[self.asked[pose], pose] = ns
                self.asked[pose] += 1
            total += ns
        return total

    def chunk(self, first, last):
        begun = time.perf_counter_ns()
        for pose in range(first, last):
            self.ask(pose)
        if time.perf_counter_ns() - begun > LONG_PASS_NS:
            return self.one_by_one(first, last)
        passes, begun = 0, time.perf_counter_ns()
        while (taken := time.perf_counter_ns() - begun) < SAMPLE_NS or passes == 0:
            for pose in range(first, last):
                self.ask(pose)
            passes += 1
        self.one_by_one(first, last)
        return taken // passes


def main():
    mode, pair, out, rounds = sys.argv[1:5]
    if mode != "first":
        answer_line("unsupported")
        return
    engine = Engine(Path(pair), int(rounds))
    answer_line("ready")
    for line in sys.stdin:
        match line.split():
            case ["build"]:
                answer_line(f"done {engine.build()}")
            case ["bytes"]:
                answer_line("done 0")
            case ["chunk", first, last]:
                answer_line(f"done {engine.chunk(int(first), int(last))}")
            case ["quit"]:
                np.save(Path(out) / "verdicts.npy", engine.verdicts)
                np.save(Path(out) / "ns.npy", engine.ns)
                answer_line("done 0")
                return
            case _:
                sys.exit(f"`{line.strip()}` is not a command")


main()

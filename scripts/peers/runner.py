"""What every runner in Python shares: arrays in and out, and the protocol of docs/adding-a-peer.md. A runner defines an engine and calls `serve`:

    class Engine:
        @staticmethod
        def has(mode): ...                # whether it can answer this; path and first are one question to it
        def __init__(self, a, b): ...     # builds its structures over both meshes, each (vertices, faces): timed
        @staticmethod
        def question(*matrices): ...      # a pose, or the two ends of a motion, in the engine's own form, made before any clock runs
        def answer(self, mode, question): # first, path: 0 or 1; all: pairs of triangles; distance: mm; motion: time of first contact, infinite without
            ...
        most_triangles = ...              # pairs with more are not answered; optional
"""

import sys
import time
from pathlib import Path

import numpy as np

SHORTEST_NS = 100_000
LONG_NS = 20_000_000


class Runner:
    """Both meshes, what is asked about them, and the answers."""

    def __init__(self, engine, mode, pair, rounds):
        load = lambda name: np.load(pair / f"{name}.npy")
        self.kind, self.mode, self.engine = engine, mode, None
        self.meshes = [(load(f"{side}_vertices"), load(f"{side}_faces")) for side in "ab"]
        matrices = [load("poses"), load("ends")] if mode == "motion" else [load("poses")]
        self.questions = [engine.question(*of_one) for of_one in zip(*matrices)]
        count = len(self.questions)
        self.answers, self.asked = np.zeros(count), np.zeros(count, dtype=int)
        self.ns = np.zeros((rounds, count), dtype=np.uint64)

    def triangles(self):
        return sum(len(faces) for _, faces in self.meshes)

    def build(self):
        begun = time.perf_counter_ns()
        self.engine = self.kind(*self.meshes)
        return time.perf_counter_ns() - begun

    def one_by_one(self, numbers):
        times = []
        for i in numbers:
            begun = time.perf_counter_ns()
            self.answers[i] = self.engine.answer(self.mode, self.questions[i])
            times.append(max(time.perf_counter_ns() - begun, 1))
        return times

    def chunk(self, first, end):
        numbers = range(first, end)
        if self.engine is None:
            self.build()
        times = self.one_by_one(numbers)
        once = total = sum(times)
        if once < LONG_NS:
            passes = max(1, -(-SHORTEST_NS // once))
            begun = time.perf_counter_ns()
            for _ in range(passes):
                for i in numbers:
                    self.answers[i] = self.engine.answer(self.mode, self.questions[i])
            total = (time.perf_counter_ns() - begun) // passes
            times = self.one_by_one(numbers)
        for i, ns in zip(numbers, times):
            if self.asked[i] < len(self.ns):
                self.ns[self.asked[i], i] = ns
                self.asked[i] += 1
        return total

    def write(self, out):
        touches = {"distance": self.answers <= 0, "motion": np.isfinite(self.answers)}.get(self.mode, self.answers > 0)
        np.save(out / "verdicts.npy", touches.astype(np.uint8))
        np.save(out / "ns.npy", self.ns)
        if self.mode in ("all", "distance", "motion"):
            np.save(out / "values.npy", self.answers)


def serve(engine):
    """Speaks the protocol; the command line is MODE PAIR OUT ROUNDS."""
    mode, pair, out, rounds = sys.argv[1:]
    if not engine.has(mode):
        print("unsupported", flush=True)
        return
    runner = Runner(engine, mode, Path(pair), int(rounds))
    if runner.triangles() > getattr(engine, "most_triangles", runner.triangles()):
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

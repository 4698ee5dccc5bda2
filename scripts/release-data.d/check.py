"""Checks a data release of bvbench, unpacked: checksums, and a sample of the verdicts by a triangle test written here alone.

    python check.py [FOLDER [SAMPLE]]      default: the folder of this file, 8 poses per pair of parts

Needs numpy. Two surfaces touch when an edge of one pierces a triangle of the other. Doubles are enough: poses within 1e-6 mm of first contact are left out.
Exit 1 when something differs.
"""

import hashlib
import sys
from pathlib import Path

import numpy as np

BLOCK = 2_000_000


def wrong_sums(folder):
    """Files that are missing, changed or not listed."""
    listed = {}
    for line in (folder / "SHA256SUMS").read_text(encoding="utf-8").splitlines():
        digest, name = line.split("  ", 1)
        listed[name] = digest
    found = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()} - {"SHA256SUMS"}
    for name in sorted(found ^ set(listed)):
        yield f"{name}: {'not listed' if name in found else 'missing'}"
    for name in sorted(found & set(listed)):
        with open(folder / name, "rb") as file:
            if hashlib.file_digest(file, "sha256").hexdigest() != listed[name]:
                yield f"{name}: changed"


def volumes(a, b, c, d):
    """Six times the signed volumes of tetrahedra."""
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)


def pierced(segments, triangles):
    """Whether each segment (n, 2, 3) crosses the triangle (n, 3, 3) beside it."""
    p, q = segments[:, 0], segments[:, 1]
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    apart = volumes(a, b, c, p) * volumes(a, b, c, q) > 0
    sides = [volumes(p, q, a, b), volumes(p, q, b, c), volumes(p, q, c, a)]
    inside = (np.minimum.reduce(sides) >= 0) | (np.maximum.reduce(sides) <= 0)
    solid = np.abs(sum(sides)) > 0
    return ~apart & inside & solid


def near(triangles, low, high):
    """Triangles whose box meets a box."""
    return triangles[(triangles.min(axis=1) <= high).all(axis=1) & (triangles.max(axis=1) >= low).all(axis=1)]


def touch(a, b):
    """Whether two sets of triangles (n, 3, 3) in one frame touch."""
    for _ in range(3):
        if not len(a) or not len(b):
            return False
        a, b = near(a, b.min(axis=(0, 1)), b.max(axis=(0, 1))), near(b, a.min(axis=(0, 1)), a.max(axis=(0, 1)))
    if not len(a) or not len(b):
        return False
    low, high = b.min(axis=1), b.max(axis=1)
    for start in range(0, len(a), max(1, BLOCK // len(b))):
        part = a[start : start + max(1, BLOCK // len(b))]
        meet = (part.min(axis=1)[:, None] <= high).all(axis=2) & (part.max(axis=1)[:, None] >= low).all(axis=2)
        i, j = np.nonzero(meet)
        for edge in ((0, 1), (1, 2), (2, 0)):
            if pierced(part[i][:, edge], b[j]).any() or pierced(b[j][:, edge], part[i]).any():
                return True
    return False


def wrong_verdicts(pair, sample):
    """How many verdicts were computed again, and those that differ."""
    a, b = (np.load(pair / f"{part}_vertices.npy")[np.load(pair / f"{part}_faces.npy")] for part in "ab")
    poses, exact, grazing = (np.load(pair / f"{name}.npy") for name in ("poses", "exact", "grazing"))
    judged = np.nonzero(grazing == 0)[0]
    # Half of them contacts, where there are as many.
    chosen = [kind[np.linspace(0, len(kind) - 1, min(len(kind), (sample + 1) // 2)).astype(int)] for kind in (judged[exact[judged] == 1], judged[exact[judged] == 0]) if len(kind)]
    chosen = np.concatenate(chosen)[:sample] if chosen else np.zeros(0, int)
    differ = []
    for index in chosen:
        moved = b @ poses[index, :, :3].T + poses[index, :, 3]
        if touch(a, moved) != bool(exact[index]):
            differ.append(f"{pair.parent.name}/{pair.name} pose {index}: exact is {exact[index]}, computed again it is {1 - exact[index]}")
    return len(chosen), differ


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent)
    sample = int(sys.argv[2]) if len(sys.argv) > 2 else 8
    wrong = list(wrong_sums(folder))
    # Arrays that are not what was packed are not computed with.
    pairs = [] if wrong else sorted(path.parent for path in folder.glob("scenes/*/*/poses.npy"))
    checked = 0
    for pair in pairs:
        count, differ = wrong_verdicts(pair, sample)
        checked += count
        wrong += differ
    for line in wrong:
        print(line)
    print(f"{len(pairs)} pairs, {checked} verdicts computed again, {len(wrong)} differences")
    return 1 if wrong or not checked else 0


if __name__ == "__main__":
    sys.exit(main())

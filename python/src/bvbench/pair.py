"""Two meshes, their poses and the truth: what ``bvbench peers export`` writes and a runner reads."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bvbench.poses import check_poses
from bvbench.run import RunError

if TYPE_CHECKING:
    import os

    import trimesh

Floats = NDArray[np.float64]

#: Arrays of the truth, which a pair may lack, and their types in files.
_TRUTH = {"exact": "|u1", "grazing": "|u1", "stratum": "|u1", "truth": "<f8"}
_NEEDED = ("a_vertices", "a_faces", "b_vertices", "b_faces", "poses")
_STRATA = ("colliding", "near-miss", "medium", "far")


def _no_floats() -> Floats:
    return np.zeros(0)


def _whole(name: str, values: ArrayLike, below: int, *columns: int) -> NDArray[Any]:
    """Whole numbers from 0 to `below` - 1, in rows of `columns`."""
    array = np.asarray(values)
    if array.ndim != 1 + len(columns) or array.shape[1:] != columns or array.dtype.kind not in "biuf":
        raise ValueError(f"{name}: {array.dtype} of shape {array.shape}, not whole numbers of shape ({', '.join(['n', *map(str, columns)])})")
    # What is no number has no remainder.
    with np.errstate(invalid="ignore"):
        bad = ~((array >= 0) & (array < below) & (array % 1 == 0))
    if bad.any():
        raise ValueError(f"{name}: {array[bad][0]} is not a whole number from 0 to {below - 1}")
    return array


def _mesh(part: str, vertices: ArrayLike, faces: ArrayLike) -> tuple[Floats, NDArray[np.uint32]]:
    points = np.asarray(vertices, np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise ValueError(f"{part}_vertices: finite numbers of shape (n, 3) are expected, not of {points.shape}")
    return points, _whole(f"{part}_faces", faces, len(points), 3).astype(np.uint32)


@dataclass
class Pair:
    """Part `b` posed in the frame of part `a`.

    Vertices are mm in each part's own frame, `poses` are (n, 4, 4) rigid motions. The truth is there when bvbench wrote the pair: `exact` says that the
    surfaces touch, `grazing` that the pose is within 1e-6 mm of first contact, where no method is judged. `chunks` are ranges of poses that are timed together.
    Raises `ValueError` for arrays of another shape, faces without their vertices, poses that are no rigid motions, and numbers out of their range.
    """

    a_vertices: Floats
    a_faces: NDArray[np.uint32]
    b_vertices: Floats
    b_faces: NDArray[np.uint32]
    poses: Floats
    chunks: NDArray[np.uint32] = field(default_factory=lambda: np.zeros((0, 2), np.uint32))
    exact: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))
    grazing: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))
    stratum: NDArray[np.uint8] = field(default_factory=lambda: np.zeros(0, np.uint8))
    truth: Floats = field(default_factory=_no_floats)

    def __post_init__(self) -> None:
        self.poses = check_poses(self.poses)
        self.a_vertices, self.a_faces = _mesh("a", self.a_vertices, self.a_faces)
        self.b_vertices, self.b_faces = _mesh("b", self.b_vertices, self.b_faces)
        count = len(self.poses)
        self.chunks = _whole("chunks", self.chunks, count + 1, 2).astype(np.uint32)
        if (self.chunks[:, 0] >= self.chunks[:, 1]).any():
            raise ValueError("chunks: a range without poses")
        self.exact = _whole("exact", self.exact, 2).astype(np.bool_)
        self.grazing = _whole("grazing", self.grazing, 2).astype(np.bool_)
        self.stratum = _whole("stratum", self.stratum, len(_STRATA)).astype(np.uint8)
        self.truth = np.asarray(self.truth, np.float64)
        # Infinite where a motion meets nothing.
        if self.truth.ndim != 1 or np.isnan(self.truth).any():
            raise ValueError(f"truth: numbers of shape (n) are expected, not of {self.truth.shape}")
        for name in _TRUTH:
            if len(getattr(self, name)) not in (0, count):
                raise ValueError(f"{name} has {len(getattr(self, name))} entries for {count} poses")

    @classmethod
    def load(cls, folder: str | os.PathLike[str]) -> Pair:
        """Reads a pair's folder. Raises `RunError` when a file lacks, is no array, or does not fit the others."""
        folder = Path(folder)
        arrays: dict[str, NDArray[Any]] = {}
        for name in (*_NEEDED, "chunks", *_TRUTH):
            path = folder / f"{name}.npy"
            try:
                arrays[name] = np.load(path, allow_pickle=False)
            except FileNotFoundError as error:
                if name in _NEEDED:
                    raise RunError(f"{path} lacks: is {folder} the folder of a pair?") from error
            except (ValueError, EOFError) as error:
                raise RunError(f"{path}: not an array: {error}") from error
        for name in _TRUTH:
            if name in arrays and arrays["poses"].size and not arrays[name].size:
                raise RunError(f"{folder / name}.npy has 0 entries for {len(arrays['poses'])} poses")
        try:
            return cls(**arrays)
        except ValueError as error:
            raise RunError(f"{folder}: {error}") from error

    @classmethod
    def from_meshes(cls, a: trimesh.Trimesh, b: trimesh.Trimesh, poses: Floats) -> Pair:
        """A pair of one's own: trimesh meshes in mm, and (n, 4, 4) or (n, 3, 4) poses of `b` in the frame of `a`, all in one chunk."""
        chunks = np.array([[0, len(poses)]][: len(poses)], np.uint32).reshape(-1, 2)
        return cls(np.asarray(a.vertices), np.asarray(a.faces), np.asarray(b.vertices), np.asarray(b.faces), poses, chunks)

    def mesh(self, part: Literal["a", "b"]) -> trimesh.Trimesh:
        """A part as a trimesh mesh, in its own frame, mm; vertices and faces as they are, nothing merged or dropped."""
        import trimesh

        vertices, faces = (self.a_vertices, self.a_faces) if part == "a" else (self.b_vertices, self.b_faces)
        return trimesh.Trimesh(vertices, faces.astype(np.int64), process=False)

    @property
    def strata(self) -> list[str]:
        """The stratum of each pose by name."""
        return [_STRATA[index] for index in self.stratum]

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Writes the arrays that a runner of ``bvbench peers`` reads, and the truth where there is one; that of a pair which was there before is removed.

        Raises `ValueError`, before anything is written, when what was set since is no pair.
        """
        folder = Path(folder)
        self.__post_init__()
        truth = {name: getattr(self, name).astype(kind) for name, kind in _TRUTH.items() if len(getattr(self, name))}
        folder.mkdir(parents=True, exist_ok=True)
        arrays = {
            "a_vertices": self.a_vertices.astype("<f8"), "a_faces": self.a_faces.astype("<u4"),
            "b_vertices": self.b_vertices.astype("<f8"), "b_faces": self.b_faces.astype("<u4"),
            "poses": self.poses[:, :3].astype("<f8"), "chunks": self.chunks.astype("<u4"),
        }  # fmt: skip
        for name in _TRUTH:
            (folder / f"{name}.npy").unlink(missing_ok=True)
        for name, array in (arrays | truth).items():
            np.save(folder / f"{name}.npy", np.ascontiguousarray(array), allow_pickle=False)

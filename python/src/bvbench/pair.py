"""Two meshes, their poses and the truth: what ``bvbench peers export`` writes and a runner reads."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from bvbench.poses import check_poses
from bvbench.run import RunError

if TYPE_CHECKING:
    import os

    import trimesh

Floats = NDArray[np.float64]

#: Arrays of the truth, which a pair may lack, and their types in files.
_TRUTH = {"exact": "|u1", "grazing": "|u1", "stratum": "|u1", "truth": "<f8"}
_STRATA = ("colliding", "near-miss", "medium", "far")


def _no_floats() -> Floats:
    return np.zeros(0)


@dataclass
class Pair:
    """Part `b` posed in the frame of part `a`.

    Vertices are mm in each part's own frame, `poses` are (n, 4, 4) rigid motions. The truth is there when bvbench wrote the pair: `exact` says that the
    surfaces touch, `grazing` that the pose is within 1e-6 mm of first contact, where no method is judged. `chunks` are ranges of poses that are timed together.
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

    @classmethod
    def load(cls, folder: str | os.PathLike[str]) -> Pair:
        """Reads a pair's folder. Raises `RunError` when a file lacks, is no array, or does not fit the others."""
        folder = Path(folder)

        def array(name: str, optional: bool = False) -> NDArray[np.generic] | None:
            path = folder / f"{name}.npy"
            try:
                values: NDArray[np.generic] = np.load(path, allow_pickle=False)
                return values
            except FileNotFoundError as error:
                if optional:
                    return None
                raise RunError(f"{path} lacks: is {folder} the folder of a pair?") from error
            except ValueError as error:
                raise RunError(f"{path}: not an array: {error}") from error

        def needed(name: str) -> NDArray[np.generic]:
            found = array(name)
            assert found is not None
            return found

        poses = needed("poses").astype(np.float64)
        if poses.ndim != 3 or poses.shape[1:] != (3, 4):
            raise RunError(f"{folder / 'poses.npy'}: the shape is {poses.shape}, not (n, 3, 4)")
        whole = np.zeros((len(poses), 4, 4))
        whole[:, :3] = poses
        whole[:, 3, 3] = 1
        pair = cls(
            needed("a_vertices").astype(np.float64), needed("a_faces").astype(np.uint32),
            needed("b_vertices").astype(np.float64), needed("b_faces").astype(np.uint32), whole,
        )  # fmt: skip
        for name, kind in (("chunks", np.uint32), ("exact", np.bool_), ("grazing", np.bool_), ("stratum", np.uint8), ("truth", np.float64)):
            found = array(name, optional=True)
            if found is not None:
                if name != "chunks" and len(found) != len(poses):
                    raise RunError(f"{folder / name}.npy has {len(found)} entries for {len(poses)} poses")
                setattr(pair, name, found.astype(kind))
        return pair

    @classmethod
    def from_meshes(cls, a: trimesh.Trimesh, b: trimesh.Trimesh, poses: Floats) -> Pair:
        """A pair of one's own: trimesh meshes in mm, and (n, 4, 4) or (n, 3, 4) poses of `b` in the frame of `a`, all in one chunk."""
        whole = check_poses(poses)
        chunks = np.array([[0, len(whole)]], np.uint32)
        return cls(
            np.asarray(a.vertices, np.float64), np.asarray(a.faces, np.uint32), np.asarray(b.vertices, np.float64), np.asarray(b.faces, np.uint32), whole, chunks
        )

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

        Raises `ValueError`, before anything is written, when the truth has not an entry for each pose.
        """
        folder = Path(folder)
        truth = {name: getattr(self, name).astype(kind) for name, kind in _TRUTH.items() if len(getattr(self, name))}
        for name, array in truth.items():
            if len(array) != len(self.poses):
                raise ValueError(f"{name} has {len(array)} entries for {len(self.poses)} poses")
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

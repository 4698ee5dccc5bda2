"""Recorded poses of a scene: a CSV of rigid motions."""

from __future__ import annotations

import codecs
import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bvbench.run import RunError

if TYPE_CHECKING:
    import os
    from collections.abc import Iterable, Mapping

_MATRIX = [f"m{row}{column}" for row in range(3) for column in range(4)]
_QUATERNION = ["qw", "qx", "qy", "qz", "tx", "ty", "tz"]

#: How far R^T R may be from 1, per entry, and the squared length of a quaternion: what bvbench takes for a rotation.
ROTATION_TOLERANCE = 1e-4
#: The farthest that bvbench moves anything, mm.
FARTHEST = 1e9


def check_poses(poses: ArrayLike) -> NDArray[np.float64]:
    """(n, 4, 4) rigid motions from (n, 4, 4) or (n, 3, 4) ones. Raises `ValueError` for another shape and for what is no rigid motion."""
    given = np.asarray(poses, np.float64)
    if given.ndim != 3 or given.shape[1:] not in ((4, 4), (3, 4)):
        raise ValueError(f"poses have shape {given.shape}, not (n, 4, 4) or (n, 3, 4)")
    whole = np.zeros((len(given), 4, 4))
    whole[:, :3] = given[:, :3]
    whole[:, 3, 3] = 1
    rotations = whole[:, :3, :3]
    bad = ~np.isfinite(given).all(axis=(1, 2))
    # What is not finite or overflows is no rotation.
    with np.errstate(all="ignore"):
        bad |= ~(np.abs(np.einsum("nij,nik->njk", rotations, rotations) - np.eye(3)).max(axis=(1, 2)) <= ROTATION_TOLERANCE)
        bad |= np.linalg.det(rotations) < 0
        bad |= np.abs(given[:, 3:] - [0, 0, 0, 1]).max(axis=(1, 2), initial=0.0) > ROTATION_TOLERANCE
    if bad.any():
        raise ValueError(f"pose {int(bad.argmax())} is not a rotation and a translation")
    return whole


def write_poses(path: str | os.PathLike[str], frames: Iterable[Mapping[str, ArrayLike]]) -> None:
    """Writes the recorded poses of a scene: for each frame the parts that move, with their (4, 4) poses in the world, mm.

    Numbers are written in full, so that `read_poses` gives the same bits.
    """
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["frame", "part", *_MATRIX])
        for number, frame in enumerate(frames):
            for part, pose in frame.items():
                matrix = check_poses(np.asarray(pose, np.float64)[None])[0]
                writer.writerow([number, part, *(repr(float(value)) for value in matrix[:3].ravel())])


def _text(path: str | os.PathLike[str]) -> str:
    """The text of a file as bvbench reads it: UTF-8, or UTF-16 with a byte-order mark, and lines that end in LF, CR LF or CR."""
    content = Path(path).read_bytes()
    is_utf16 = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        return content.decode("utf-16" if is_utf16 else "utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise RunError(f"{path}:{line}: {error}") from error


def _number(text: str) -> float:
    """A number as bvbench reads it; Python would take `1_0` for 10."""
    if "_" in text or not text.isascii():
        raise ValueError(f"could not convert string to float: {text!r}")
    value = float(text)
    if abs(value) > FARTHEST:
        raise ValueError(f"{value} is beyond {FARTHEST:.0e} mm; is the unit right?")
    return value


def read_poses(path: str | os.PathLike[str]) -> list[dict[str, NDArray[np.float64]]]:
    """Reads the recorded poses of a scene, with matrices or quaternions: for each frame the parts that it names. Raises `RunError` with file and line."""
    frames: list[dict[str, NDArray[np.float64]]] = []
    last: str | None = None
    seen: set[str] = set()
    # Comments are blank lines, so that the reader counts them.
    reader = csv.reader("\n" if line.startswith("#") else line for line in io.StringIO(_text(path), newline=None))
    rows = ([field.strip() for field in row] for row in reader if row)
    try:
        header = next(rows, [])
        has_frame = header[:1] == ["frame"]
        numbers = header[2:] if has_frame else header[1:]
        if header[has_frame : has_frame + 1] != ["part"] or numbers not in (_MATRIX, _QUATERNION):
            raise RunError(f"{path}:{max(reader.line_num, 1)}: the columns must be [frame,]part,{','.join(_QUATERNION)} or [frame,]part,{','.join(_MATRIX)}")
        for row in rows:
            try:
                values = [_number(value) for value in row[1 + has_frame :]]
                pose = check_poses((_from_quaternion(values) if numbers == _QUATERNION else np.reshape(values, (3, 4)))[None])[0]
            except ValueError as error:
                raise RunError(f"{path}:{reader.line_num}: {error}") from error
            frame = row[0] if has_frame else None
            if not frames or frame is None or frame != last:
                if frame is not None and frame in seen:
                    raise RunError(f"{path}:{reader.line_num}: frame `{frame}` comes again after another; sort the rows by frame")
                seen.add(frame or "")
                frames.append({})
            last = frame
            part = row[int(has_frame)]
            if part in frames[-1]:
                raise RunError(f"{path}:{reader.line_num}: `{part}` has a pose in this frame already")
            frames[-1][part] = pose
    except csv.Error as error:
        raise RunError(f"{path}:{reader.line_num}: {error}") from error
    if not frames:
        raise RunError(f"{path}:1: there is no pose in the file")
    return frames


def _from_quaternion(values: list[float]) -> NDArray[np.float64]:
    """The motion of a unit quaternion (w, x, y, z) and a translation."""
    if len(values) != 7:
        raise ValueError(f"{len(values)} numbers, not 7")
    squared = sum(value * value for value in values[:4])
    if not abs(squared - 1) <= ROTATION_TOLERANCE:
        raise ValueError("the quaternion's length is not 1")
    w, x, y, z = (value / squared**0.5 for value in values[:4])
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), values[4]],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), values[5]],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), values[6]],
        ]
    )

"""The check of a data release: it passes what is right and finds what was changed."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

import bvbench

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
CHECK = SCRIPTS / "release-data.d" / "check.py"


def sums(folder: Path) -> None:
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.name != "SHA256SUMS")
    lines = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.relative_to(folder).as_posix()}\n" for path in files]
    (folder / "SHA256SUMS").write_text("".join(lines), encoding="utf-8")


def check(folder: Path) -> tuple[int, str]:
    done = subprocess.run([sys.executable, str(CHECK), str(folder), "40"], capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


@pytest.fixture
def release(tmp_path: Path) -> Path:
    """Two balls of radius 5 at distances from 8 to 12, some of them moved off the axis: they touch up to about 10."""
    ball = trimesh.creation.icosphere(3, 5.0)
    poses = np.repeat(np.eye(4)[None], 40, axis=0)
    poses[:, 0, 3] = np.linspace(8, 12, 40)
    poses[20:, :3, :3] = trimesh.transformations.rotation_matrix(0.7, (1, 1, 0))[:3, :3]
    pair = bvbench.Pair.from_meshes(ball, ball, poses)
    distance = poses[:, 0, 3]
    pair.exact, pair.grazing = distance < 10, np.abs(distance - 10) < 0.1
    pair.stratum, pair.truth = np.where(pair.exact, 0, 2).astype(np.uint8), np.zeros(40)
    pair.save(tmp_path / "scenes" / "balls" / "a-b")
    sums(tmp_path)
    return tmp_path


def test_a_right_release_passes(release: Path) -> None:
    code, said = check(release)
    assert (code, said.strip()) == (0, "1 pairs, 38 verdicts computed again, 0 differences")


def test_a_wrong_verdict_is_found(release: Path) -> None:
    path = release / "scenes/balls/a-b/exact.npy"
    exact = np.load(path)
    exact[3] = 0
    exact[39] = 1
    np.save(path, exact)
    sums(release)
    code, said = check(release)
    assert code == 1
    assert "a-b pose 3: exact is 0, computed again it is 1" in said
    assert "a-b pose 39: exact is 1, computed again it is 0" in said


def test_changed_missing_and_added_files_are_found(release: Path) -> None:
    faces = release / "scenes/balls/a-b/a_faces.npy"
    faces.write_bytes(faces.read_bytes()[:-1] + b"\x01")
    (release / "scenes/balls/a-b/truth.npy").unlink()
    (release / "more.txt").write_text("", encoding="utf-8")
    code, said = check(release)
    assert code == 1
    for words in ("a_faces.npy: changed", "truth.npy: missing", "more.txt: not listed"):
        assert words in said


def test_a_thin_contact_is_found_by_the_triangles() -> None:
    # One edge through a large triangle, no vertex of either inside the other; and the same edge beside it.
    sys.path.insert(0, str(CHECK.parent))
    try:
        from check import touch
    finally:
        sys.path.pop(0)
    large = np.array([[[0, 0, 0], [100, 0, 0], [0, 100, 0]]], float)
    needle = np.array([[[30, 30, -5], [30, 30, 5], [31, 30, 5]]], float)
    assert touch(large, needle)
    assert not touch(large, needle + [60, 60, 0])
    assert not touch(large, needle + [0, 0, 6])


@pytest.mark.skipif("BVBENCH" not in os.environ, reason="BVBENCH names no program")
def test_a_release_of_the_committed_run_passes_and_has_the_same_bytes_twice(tmp_path: Path) -> None:
    script = str(SCRIPTS / "release-data")
    for name in ("one.tar.gz", "two.tar.gz"):
        subprocess.run([script, "--poses", "48", "--out", str(tmp_path / name)], check=True)
    assert (tmp_path / "one.tar.gz").read_bytes() == (tmp_path / "two.tar.gz").read_bytes()
    done = subprocess.run([script, "--check", str(tmp_path / "one.tar.gz"), "--sample", "4"], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "3 pairs, 12 verdicts computed again, 0 differences"

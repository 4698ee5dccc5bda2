"""The check of a data release: it passes what is right and finds what was changed."""

import hashlib
import io
import json
import os
import random
import subprocess
import sys
import tarfile
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
    # The scenes are those that the run read, whatever they are today.
    with tarfile.open(tmp_path / "one.tar.gz") as archive:
        archive.extractall(tmp_path, filter="data")
    [top] = tmp_path.glob("*/run")
    manifest = json.loads((top / "manifest.json").read_text(encoding="utf-8"))
    for scene in manifest["scenes"]:
        told = subprocess.run([os.environ["BVBENCH"], "scene", "info", top.parent / "scenes" / scene["name"], "--json"], capture_output=True, check=True)
        assert json.loads(told.stdout)["inputs"].items() <= manifest["inputs"].items()


@pytest.mark.skipif("BVBENCH" not in os.environ, reason="BVBENCH names no program")
@pytest.mark.parametrize(
    ("inputs", "fault"),
    [
        ({"lathe-toolpost/scene.toml": "00"}, "not the files that the run read: lathe-toolpost/scene.toml; pack the run in a clone that has its revision, 489fd31d"),
        ({"lathe-toolpost/arm.stl": "00"}, "not bvbench's own, so not ours to release: lathe-toolpost/arm.stl"),
        ({"lathe-toolpost/../../LICENSE-MIT": "00"}, "not bvbench's own"),
        ({"lathe-toolpost/README.md": "00"}, "not the files that the run read: lathe-toolpost/README.md"),
    ],
)
def test_scenes_that_the_run_did_not_read_are_not_packed(tmp_path: Path, inputs: dict[str, str], fault: str) -> None:
    manifest = json.loads((SCRIPTS.parent / "results/reference/manifest.json").read_text(encoding="utf-8"))
    manifest["inputs"] |= inputs
    (tmp_path / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    refused = subprocess.run([str(SCRIPTS / "release-data"), "--out", str(tmp_path / "made.tar.gz"), str(tmp_path)], capture_output=True, text=True)
    assert (refused.returncode, fault in refused.stderr) == (2, True), refused.stderr
    assert not (tmp_path / "made.tar.gz").exists()


def test_an_archive_that_is_cut_short_or_broken_is_no_input(tmp_path: Path) -> None:
    path = tmp_path / "made.tar.gz"
    with tarfile.open(path, "w:gz") as archive:
        entry = tarfile.TarInfo("top/noise")
        entry.size = 100_000
        archive.addfile(entry, io.BytesIO(random.Random(1).randbytes(entry.size)))
    whole = path.read_bytes()
    for content in (whole[:50_000], whole[:1000] + bytes(1000) + whole[2000:], whole[:20] + b"\xff" * 40 + whole[60:], b"no archive", b""):
        path.write_bytes(content)
        done = subprocess.run([sys.executable, str(SCRIPTS / "release-data.d/main.py"), "--home", str(tmp_path), "--check", str(path)], capture_output=True, text=True)
        assert (done.returncode, done.stderr.startswith(f"error: {path}")) == (2, True), done.stderr

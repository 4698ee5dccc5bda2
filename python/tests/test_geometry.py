from pathlib import Path

import numpy as np
import pytest
import trimesh

import bvbench


def turned(angle: float, offset: tuple[float, float, float]) -> np.ndarray:
    pose = trimesh.transformations.rotation_matrix(angle, (1, 2, 3))
    pose[:3, 3] = offset
    return pose


def test_a_pair_goes_to_files_and_back_and_to_trimesh(tmp_path: Path) -> None:
    a, b = trimesh.creation.box((10, 20, 30)), trimesh.creation.icosphere(2, 5.0)
    poses = np.array([turned(0.3, (1, 2, 3)), turned(1.0, (40, 0, 0))])
    pair = bvbench.Pair.from_meshes(a, b, poses)
    pair.save(tmp_path)
    back = bvbench.Pair.load(tmp_path)
    assert (back.poses == poses).all()
    assert (back.mesh("a").vertices == a.vertices).all()
    assert (back.mesh("b").faces == b.faces).all()
    assert np.load(tmp_path / "a_faces.npy").dtype == np.dtype("<u4")
    assert back.chunks.tolist() == [[0, 2]]
    assert back.mesh("b").volume == pytest.approx(b.volume)


def test_what_does_not_fit_is_named(tmp_path: Path) -> None:
    box = trimesh.creation.box((1, 1, 1))
    with pytest.raises(ValueError, match="pose 0 is not a rotation"):
        bvbench.Pair.from_meshes(box, box, np.diag([1.0, 1.0, -1.0, 1.0])[None])
    bvbench.Pair.from_meshes(box, box, np.eye(4)[None]).save(tmp_path)
    np.save(tmp_path / "exact.npy", np.zeros(3, np.uint8))
    with pytest.raises(bvbench.RunError, match="3 entries for 1 poses"):
        bvbench.Pair.load(tmp_path)
    (tmp_path / "poses.npy").unlink()
    with pytest.raises(bvbench.RunError, match=r"poses.npy lacks"):
        bvbench.Pair.load(tmp_path)


def test_recorded_poses_keep_their_bits(tmp_path: Path) -> None:
    frames = [{"tool": turned(0.1, (1 / 3, 2, 3))}, {"tool": turned(0.2, (4, 5, 6)), "vice": np.eye(4)}]
    bvbench.write_poses(tmp_path / "poses.csv", frames)
    back = bvbench.read_poses(tmp_path / "poses.csv")
    assert [sorted(frame) for frame in back] == [["tool"], ["tool", "vice"]]
    assert all((back[i][part] == frames[i][part]).all() for i in range(2) for part in frames[i])


def test_quaternions_are_read(tmp_path: Path) -> None:
    (tmp_path / "poses.csv").write_text("part,qw,qx,qy,qz,tx,ty,tz\ntool,0.7071067811865476,0,0,0.7071067811865476,1,2,3\n", encoding="utf-8")
    [frame] = bvbench.read_poses(tmp_path / "poses.csv")
    assert frame["tool"] @ [1, 0, 0, 1] == pytest.approx([1, 3, 3, 1])


def test_a_bad_row_is_named(tmp_path: Path) -> None:
    (tmp_path / "poses.csv").write_text("part,qw,qx,qy,qz,tx,ty,tz\ntool,1,0,0,0,1,2,x\n", encoding="utf-8")
    with pytest.raises(bvbench.RunError, match=r"poses.csv:2: could not convert"):
        bvbench.read_poses(tmp_path / "poses.csv")

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


def test_the_truth_of_a_pair_that_was_there_before_is_gone(tmp_path: Path) -> None:
    box = trimesh.creation.box((1, 1, 1))
    pair = bvbench.Pair.from_meshes(box, box, np.stack([np.eye(4), np.eye(4)]))
    pair.exact, pair.grazing, pair.stratum, pair.truth = np.array([True, False]), np.zeros(2, bool), np.array([0, 3], np.uint8), np.array([0.0, 5.0])
    pair.save(tmp_path)
    assert bvbench.Pair.load(tmp_path).strata == ["colliding", "far"]
    pair.truth = np.zeros(0)
    pair.save(tmp_path)
    assert bvbench.Pair.load(tmp_path).exact.tolist() == [True, False] and not (tmp_path / "truth.npy").exists()
    bvbench.Pair.from_meshes(box, box, np.stack([np.eye(4), np.eye(4)])).save(tmp_path)
    assert len(bvbench.Pair.load(tmp_path).exact) == 0
    pair.grazing = np.zeros(3, bool)
    with pytest.raises(ValueError, match="grazing has 3 entries for 2 poses"):
        pair.save(tmp_path / "new")
    assert not (tmp_path / "new").exists()


def test_only_rigid_motions_are_poses() -> None:
    bad = [np.eye(4) for _ in range(7)]
    bad[0][0, 3], bad[1][0, 0], bad[2][1, 2] = np.nan, np.nan, np.inf
    bad[3][3, 0], bad[4][3, 3] = 1, 2
    bad[5][0, 0] = 1e200
    bad[6] = np.zeros((4, 4))
    for number, pose in enumerate(bad):
        with pytest.raises(ValueError, match="pose 1 is not a rotation and a translation"):
            bvbench.poses.check_poses([np.eye(4), pose])
            pytest.fail(f"pose {number} passes")
    assert (bvbench.poses.check_poses([np.eye(4)[:3]]) == np.eye(4)).all()
    assert bvbench.poses.check_poses(np.zeros((0, 4, 4))).shape == (0, 4, 4)


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
    header = "part,qw,qx,qy,qz,tx,ty,tz\n"
    for text, message in [
        (f"{header}tool,1,0,0,0,1,2,x\n", "2: could not convert"),
        (f"# a comment\n{header}# another\n\ntool,1,0,0,0,1,2,x\n", "5: could not convert"),
        (f"{header}tool,2,0,0,0,1,2,3\n", "2: the quaternion's length is not 1"),
        (f"{header}tool,0,0,0,0,1,2,3\n", "2: the quaternion's length is not 1"),
        (f"{header}tool,nan,0,0,0,1,2,3\n", "2: the quaternion's length is not 1"),
        (f"{header}tool,1,0,0,0,1,nan,3\n", "2: pose 0 is not"),
        (f"{header}tool,1,0,0\n", "2: 3 numbers, not 7"),
        ("# a comment\npart,x,y\n", "2: the columns must be"),
        ("", "1: the columns must be"),
        (header, "1: there is no pose"),
        (f"frame,{header},tool,1,0,0,0,1,2,3\n,tool,1,0,0,0,1,2,3\n", "3: `tool` has a pose in this frame already"),
        (f"frame,{header}1,tool,1,0,0,0,1,2,3\n2,tool,1,0,0,0,1,2,3\n1,vice,1,0,0,0,1,2,3\n", "4: frame `1` comes again"),
    ]:
        (tmp_path / "poses.csv").write_text(text, encoding="utf-8")
        with pytest.raises(bvbench.RunError, match=f"poses.csv:{message}"):
            bvbench.read_poses(tmp_path / "poses.csv")


def test_spaces_and_blank_lines_mean_nothing(tmp_path: Path) -> None:
    text = "frame , part,qw,qx,qy,qz,tx,ty,tz\n1,tool,1,0,0,0,1,2,3\n1 , vice,1,0,0,0,4,5,6\n\n# a comment\n2,tool,1,0,0,0,7,8,9\n\n"
    (tmp_path / "poses.csv").write_text(text, encoding="utf-8")
    assert [sorted(frame) for frame in bvbench.read_poses(tmp_path / "poses.csv")] == [["tool", "vice"], ["tool"]]

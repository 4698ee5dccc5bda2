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
    (tmp_path / "poses.npy").write_bytes(b"")
    with pytest.raises(bvbench.RunError, match=r"poses.npy: not an array"):
        bvbench.Pair.load(tmp_path)


def test_what_is_no_pair_is_refused_whichever_way_it_comes(tmp_path: Path) -> None:
    box = trimesh.creation.box((1, 1, 1))
    good = bvbench.Pair.from_meshes(box, box, np.stack([np.eye(4)] * 3))
    good.exact, good.grazing, good.stratum, good.truth = np.ones(3, bool), np.zeros(3, bool), np.zeros(3, np.uint8), np.zeros(3)
    good.save(tmp_path)
    nowhere = np.stack([np.eye(4)[:3]] * 3)
    scaled = 2 * nowhere
    nowhere[1, 0, 3] = np.nan
    for name, values, message in [
        ("a_faces", np.array([[0, 1, -1]]), "-1 is not a whole number from 0 to 7"),
        ("a_faces", np.array([[0, 1, 1.5]]), "1.5 is not"),
        ("b_faces", np.array([[0, 1, 8]], np.uint32), "8 is not"),
        ("b_faces", np.array([[0, 1, np.nan]]), "nan is not"),
        ("b_faces", np.array([0, 1, 2]), r"int64 of shape \(3,\), not whole numbers of shape \(n, 3\)"),
        ("a_vertices", np.full((8, 3), np.inf), "finite numbers of shape"),
        ("a_vertices", np.zeros((8, 2)), "finite numbers of shape"),
        ("chunks", np.array([[0, 4]], np.uint32), "4 is not a whole number from 0 to 3"),
        ("chunks", np.array([[2, 2]], np.uint32), "a range without poses"),
        ("chunks", np.array([0, 3], np.uint32), r"shape \(n, 2\)"),
        ("poses", nowhere, "pose 1 is not a rotation"),
        ("poses", scaled, "pose 0 is not a rotation"),
        ("poses", np.zeros((3, 2, 4)), "poses have shape"),
        ("stratum", np.array([0, 1, 4], np.uint8), "4 is not a whole number from 0 to 3"),
        ("exact", np.array([0, 1, 2], np.uint8), "2 is not a whole number from 0 to 1"),
        ("grazing", np.zeros((3, 1), np.uint8), r"shape \(n\)"),
        ("truth", np.array([0, 1, np.nan]), "truth: numbers"),
        ("truth", np.zeros(2), "2 entries for 3 poses"),
    ]:
        shown = {field: getattr(good, field) for field in good.__dataclass_fields__}
        with pytest.raises(ValueError, match=message):
            bvbench.Pair(**(shown | {name: values}))
        folder = tmp_path / "bad"
        good.save(folder)
        np.save(folder / f"{name}.npy", values)
        with pytest.raises(bvbench.RunError, match=message):
            bvbench.Pair.load(folder)
        other = bvbench.Pair(**shown)
        setattr(other, name, values)
        with pytest.raises(ValueError, match=message):
            other.save(tmp_path / "new")
    assert not (tmp_path / "new").exists()
    assert bvbench.Pair.load(tmp_path).exact.tolist() == [True] * 3


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
        (f"{header}tool,1,0,0,0,1_0,2,3\n", "2: could not convert"),
        (f"{header}tool,1,0,0,0,１,2,3\n", "2: could not convert"),
        (f"{header}tool,1,0,0,0,-1.1e9,2,3\n", "2: -1100000000.0 is beyond 1e[+]09 mm; is the unit right"),
        (f"{header}tool,1,0,0,0,1,2,inf\n", "2: inf is beyond"),
        (f"{header}{'tool' * 50_000},1,0,0,0,1,2,3\n", "2: field larger"),
        ("# a comment\npart,x,y\n", "2: the columns must be"),
        ("", "1: the columns must be"),
        (header, "1: there is no pose"),
        (f"frame,{header},tool,1,0,0,0,1,2,3\n,tool,1,0,0,0,1,2,3\n", "3: `tool` has a pose in this frame already"),
        (f"frame,{header}1,tool,1,0,0,0,1,2,3\n2,tool,1,0,0,0,1,2,3\n1,vice,1,0,0,0,1,2,3\n", "4: frame `1` comes again"),
    ]:
        (tmp_path / "poses.csv").write_text(text, encoding="utf-8")
        with pytest.raises(bvbench.RunError, match=f"poses.csv:{message}"):
            bvbench.read_poses(tmp_path / "poses.csv")


def test_every_encoding_and_line_end_that_bvbench_reads_is_read(tmp_path: Path) -> None:
    path, text = tmp_path / "poses.csv", "part,qw,qx,qy,qz,tx,ty,tz\nü,1,0,0,0,1,2,1e9\n"
    for content in (
        text.encode("utf-8-sig"),
        text.encode("utf-16"),
        b"\xfe\xff" + text.encode("utf-16-be"),
        text.replace("\n", "\r\n").encode(),
        text.replace("\n", "\r").encode("utf-16"),
    ):
        path.write_bytes(content)
        [frame] = bvbench.read_poses(path)
        assert frame["ü"][:3, 3].tolist() == [1, 2, 1e9]
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(bvbench.RunError, match="poses.csv:2: 'utf-8' codec"):
        bvbench.read_poses(path)


def test_spaces_and_blank_lines_mean_nothing(tmp_path: Path) -> None:
    text = "frame , part,qw,qx,qy,qz,tx,ty,tz\n1,tool,1,0,0,0,1,2,3\n1 , vice,1,0,0,0,4,5,6\n\n# a comment\n2,tool,1,0,0,0,7,8,9\n\n"
    (tmp_path / "poses.csv").write_text(text, encoding="utf-8")
    assert [sorted(frame) for frame in bvbench.read_poses(tmp_path / "poses.csv")] == [["tool", "vice"], ["tool"]]

"""What trimesh's own tests do not ask of the manager that stands in for its own."""

import itertools
import sys
import threading
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from test_face import at, turned

import obbtree


def test_depths_of_convex_solids_are_the_least_motion_that_parts_them():
    random = np.random.default_rng(3)
    shapes = [
        trimesh.creation.box(extents=[1, 2, 3]),
        trimesh.creation.icosphere(subdivisions=1),
        trimesh.convex.convex_hull(random.standard_normal((12, 3))),
    ]
    deep = 0
    for i in range(60):
        a, b = shapes[i % 3], shapes[(i // 3) % 3]
        pose = turned(random, 1.5)
        overlap = obbtree.Convex(a).penetration(obbtree.Convex(b), pose)
        # The Minkowski difference contains the origin where they overlap; its nearest facet is as far away as they are deep.
        moved = b.vertices @ pose[:3, :3].T + pose[:3, 3]
        hull = trimesh.convex.convex_hull((moved[None] - a.vertices[:, None]).reshape(-1, 3))
        heights = np.einsum("ij,ij->i", hull.face_normals, -hull.triangles[:, 0])
        if overlap is None:
            assert heights.max() > -1e-9
            continue
        deep += 1
        assert overlap.depth == pytest.approx(-heights.max(), abs=1e-6)
        first, second = np.array(overlap.points)
        np.testing.assert_allclose(first - second, np.array(overlap.normal) * overlap.depth, atol=1e-9)
        apart = np.eye(4)
        apart[:3, 3] = np.array(overlap.normal) * (overlap.depth + 1e-6)
        assert obbtree.Convex(a).penetration(obbtree.Convex(b), apart @ pose) is None
    assert 15 < deep < 60


def test_what_is_inside_a_convex_solid_collides_with_it():
    box, torus = trimesh.creation.box(extents=[9, 9, 9]), trimesh.creation.torus(1.0, 0.3)
    for inner in (trimesh.creation.box(), torus):
        manager = obbtree.CollisionManager()
        manager.add_object("outer", box)
        hit, names, data = manager.in_collision_single(inner, at(1), return_names=True, return_data=True)
        assert hit and names == {"outer"} and data[0].names == {"outer", "__external"}
        assert not manager.in_collision_single(inner, at(20))
    # A point of the contact is in both: a corner of what is inside, whichever comes first.
    parts = [("box", box, at(30)), ("torus", torus, at(31))]
    for order in (parts, parts[::-1]):
        manager = obbtree.CollisionManager()
        for part in order:
            manager.add_object(*part)
        hit, data = manager.in_collision_internal(return_data=True)
        assert hit and len(data) == 1
        corners = torus.triangles[data[0].index("torus")] + [31, 0, 0]
        assert np.abs(corners - data[0].point).max(axis=1).min() < 1e-12
    # It is at distance 0, and two solids at their depth; what touches or is outside has the distance of surfaces.
    manager = obbtree.CollisionManager()
    manager.add_object("box", box)
    assert manager.min_distance_single(trimesh.creation.box()) == pytest.approx(-5.0)
    assert manager.min_distance_single(torus, at(20)) == pytest.approx(20 - 4.5 - 1.3)
    assert manager.min_distance_single(torus, at(4.5)) == 0.0
    distance, name, data = manager.min_distance_single(torus, at(1), return_name=True, return_data=True)
    assert distance == data.distance == 0.0 and name == "box" and data.names == {"box", "__external"}
    corners = torus.triangles[data.index("__external")] + [1, 0, 0]
    assert np.abs(corners - data.point("box")).max(axis=1).min() < 1e-12
    np.testing.assert_array_equal(data.point("box"), data.point("__external"))
    for order in (parts, parts[::-1]):
        manager = obbtree.CollisionManager()
        for part in order:
            manager.add_object(*part)
        manager.add_object("far", torus, at(60))
        assert manager.min_distance_internal(return_names=True) == (0.0, ("box", "torus"))
        assert manager.min_distance_internal("torus", return_names=True) == (0.0, ("box", "torus"))
        assert manager.min_distance_internal("far") == pytest.approx(60 - 30 - 4.5 - 1.3)
        other = obbtree.CollisionManager()
        other.add_object("inner", torus, at(29))
        manager.remove_object("torus")
        assert manager.min_distance_other(other, return_names=True) == (0.0, ("box", "inner"))
        assert other.min_distance_other(manager) == 0.0
    # A surface holds nothing.
    manager = obbtree.CollisionManager()
    manager.add_object("outer", trimesh.creation.torus(10.0, 4.0))
    assert not manager.in_collision_single(trimesh.creation.box(), at(10))
    assert manager.min_distance_single(trimesh.creation.box(), at(10)) > 0


def test_contacts_of_surfaces_have_faces_points_normals_and_depths():
    manager = obbtree.CollisionManager()
    torus = trimesh.creation.torus(2.0, 0.5)
    manager.add_object("a", torus)
    manager.add_object("b", torus, at(4.5, 0.1))
    hit, data = manager.in_collision_internal(return_data=True)
    assert hit and len(data) > 3
    for contact in data:
        assert contact.names == {"a", "b"} and 0 <= contact.index("a") < len(torus.faces)
        assert np.linalg.norm(contact.normal) == pytest.approx(1.0) and 0 <= contact.depth < 1
        corners = torus.triangles[contact.index("b")] + [4.5, 0.1, 0]
        assert np.all(contact.point >= corners.min(axis=0) - 1e-9) and np.all(contact.point <= corners.max(axis=0) + 1e-9)
    assert manager.min_distance_internal() == 0.0


def test_normals_point_to_what_was_added_later():
    manager, box, torus = obbtree.CollisionManager(), trimesh.creation.box(), trimesh.creation.torus(2.0, 0.5)
    for i in range(120):
        manager.add_object(f"far {i}", box, at(0, 100 * i + 100))
        # Two solids and two surfaces, the second to the right of the first.
        for mesh, apart in ((box, 0.9), (torus, 4.9)):
            manager.add_object("second", mesh, at(apart))
            manager.add_object("first", mesh)
            manager.add_object("second", mesh, at(apart))
            data = manager.in_collision_internal(return_data=True)[1]
            assert data and all(contact.normal[0] > 0 for contact in data), i


def test_transforms_may_scale():
    manager = obbtree.CollisionManager()
    manager.add_object("cube", trimesh.creation.box(), np.diag([4.0, 1.0, 1.0, 1.0]))
    probe = trimesh.creation.box()
    assert manager.in_collision_single(probe, at(2.4)) and not manager.in_collision_single(probe, at(2.6))
    manager.set_transform("cube", at(1))
    assert manager.min_distance_single(probe, at(4)) == pytest.approx(2.0)
    manager.set_transform("cube", np.diag([1.0, 1.0, -2.0, 1.0]))
    assert manager.min_distance_single(probe, at(0, 0, 3)) == pytest.approx(1.5)


def test_later_changes_of_a_mesh_do_not_count():
    probe = trimesh.creation.box(extents=[0.1, 0.1, 0.1])
    for first in (np.eye(4), np.diag([3.0, 1.0, 1.0, 1.0])):
        manager, box = obbtree.CollisionManager(), trimesh.creation.box()
        manager.add_object("box", box, first)
        box.apply_translation([50, 0, 0])
        box.faces = box.faces[:4]
        for transform in (at(0.1), np.diag([2.0, 1.0, 1.0, 1.0]), at()):
            manager.set_transform("box", transform)
            # A solid that holds the probe, where it was.
            assert manager.in_collision_single(probe) and not manager.in_collision_single(probe, at(50))


def test_a_mesh_is_not_taken_for_another_of_the_same_bytes():
    box, probe = trimesh.creation.box(), trimesh.creation.box(extents=[0.1, 0.1, 0.1])
    block, shell = (SimpleNamespace(vertices=box.vertices, faces=box.faces, is_convex=is_convex) for is_convex in (True, False))
    corners, needle = [[0.0, 0, 0], [10, 0, 0], [0, 10, 0]], [[2.0, 2, -1], [2, 2.1, -1], [2, 2, 1]]
    plate, edges, needle = (
        SimpleNamespace(vertices=np.array(vertices), faces=np.array(faces, dtype), is_convex=False)
        for vertices, faces, dtype in (
            (corners, [[0, 1, 2]], "<i8"),
            (corners, [[0, 0, 1], [0, 2, 0]], "<i4"),
            (needle, [[0, 1, 2]], "<i8"),
        )
    )
    assert plate.faces.tobytes() == edges.faces.tobytes()
    for first, second, asked, hit in (
        (shell, block, probe, True),
        (block, shell, probe, False),
        (edges, plate, needle, True),
        (plate, edges, needle, False),
    ):
        manager = obbtree.CollisionManager()
        manager.add_object("first", first, at(50))
        manager.add_object("second", second)
        assert manager.in_collision_single(asked) is hit
        assert (manager.min_distance_single(asked) <= 0) is hit
        # Another transform keeps what it is.
        manager.set_transform("second", np.diag([1.5, 1.0, 1.0, 1.0]))
        assert manager.in_collision_single(asked) is hit


def in_threads(work, values):
    """Calls `work` with each value in a thread of its own; the threads take turns as often as can be."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        threads = [threading.Thread(target=work, args=(value,)) for value in values]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
    finally:
        sys.setswitchinterval(interval)


def test_threads_may_share_a_manager():
    manager, errors = obbtree.CollisionManager(), []
    manager.add_object("box", trimesh.creation.box())

    class Triangle:
        faces, is_convex = np.array([[0, 1, 2]]), False

        def __init__(self, x):
            self.vertices = np.array([[x, 0, 5.0], [1, 0, 5], [0, 1, 5]])

    def ask(first):
        try:
            assert not any(manager.in_collision_single(Triangle(first + i)) for i in range(400))
        except BaseException as error:
            errors.append(error)

    in_threads(ask, [1000.0 * i for i in range(8)])
    assert not errors and len(manager._kept) <= 64 + 8


def test_threads_may_change_different_objects_of_a_manager():
    manager, box, probe = obbtree.CollisionManager(), trimesh.creation.box(), trimesh.creation.box(extents=[0.1, 0.1, 0.1])
    assert box.is_convex

    def change(first):
        for i in range(first, 300, 8):
            manager.add_object(-1 - i, box)
            manager.add_object(i, box)
            manager.set_transform(i, at(10.0 * i))
            manager.remove_object(-1 - i)

    in_threads(change, range(8))
    assert len(manager._manager) == len(manager._objs) == 300
    assert [i for i in range(300) if manager.in_collision_single(probe, at(10.0 * i), return_names=True) != (True, {i})] == []


def test_small_scales_and_shears_are_done_to_the_mesh():
    # The end of a bar moves by 5e-3 k along x or y; a wall stands on either side of where it comes to.
    bar, wall = trimesh.creation.box(extents=[10000, 10, 10]), trimesh.creation.box(extents=[50, 50, 50])
    for k, axis in itertools.product((1, 2, 4, 6, 40), (0, 1)):
        transform = np.eye(4)
        transform[axis, 0] += k * 1e-6
        before = bar.copy()
        before.apply_transform(transform)
        one, other = obbtree.CollisionManager(), obbtree.CollisionManager()
        one.add_object("bar", bar, transform)
        other.add_object("bar", before)
        for gap, hit in ((0.6, False), (-0.1, True)):
            pose = at(5000)
            pose[axis, 3] = before.bounds[1][axis] + 25 + gap * 5e-3 * k
            assert one.in_collision_single(wall, pose) is other.in_collision_single(wall, pose) is hit
            assert one.min_distance_single(wall, pose) == pytest.approx(other.min_distance_single(wall, pose), abs=1e-9)
    # Of two that are taken as rigid, one may be seen from the other.
    box, scales = trimesh.creation.box(), [np.diag([s, s, s, 1.0]) for s in (1 + 4.9e-7, 1 - 4.9e-7)]
    for first, second in itertools.product(scales, scales):
        manager = obbtree.CollisionManager()
        manager.add_object("box", box, first)
        assert manager.min_distance_single(box, at(0.9) @ second) == pytest.approx(-0.1, abs=2e-6)
        manager.set_transform("box", second)
        assert manager.in_collision_single(trimesh.creation.torus(0.2, 0.1), first)
    # What single precision leaves of a rotation makes no tree.
    manager, random = obbtree.CollisionManager(), np.random.default_rng(4)
    bar_object = manager.add_object("bar", bar)
    collider = bar_object.collider
    for _ in range(100):
        manager.set_transform("bar", turned(random, 1.0).astype(np.float32))
        assert bar_object.collider is collider


def test_transforms_have_the_last_row_of_one():
    manager, box = obbtree.CollisionManager(), trimesh.creation.box()
    manager.add_object("box", box)
    # Translations of row vectors, and a weight.
    last_rows = [[100, 0, 0, 1], [0, 0, 1e-9, 1], [0, 0, 0, 5], [0, 0, 0, np.nan]]
    for scale, last_row in itertools.product((1.0, 25.4), last_rows):
        transform = np.diag([scale, scale, scale, 1.0])
        transform[3] = last_row
        for ask in (
            lambda: manager.add_object("other", box, transform),
            lambda: manager.set_transform("box", transform),
            lambda: manager.in_collision_single(box, transform),
            lambda: manager.min_distance_single(box, transform),
        ):
            with pytest.raises(ValueError, match="last row"):
                ask()


def test_a_mirrored_mesh_is_as_one_that_was_mirrored_before():
    torus, mirror = trimesh.creation.torus(2.0, 0.5), np.diag([1.0, 1.0, -1.0, 1.0])
    before = trimesh.Trimesh(torus.vertices @ mirror[:3, :3], torus.faces[:, ::-1], process=False)
    found = []
    for mesh, transform in ((torus, mirror), (before, None)):
        manager = obbtree.CollisionManager()
        manager.add_object("torus", mesh, transform)
        manager.add_object("other", torus, at(4.5, 0.1, 0.2))
        found.append(manager.in_collision_internal(return_data=True)[1])
    assert len(found[0]) > 10
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one.normal, other.normal, atol=1e-12)
        assert one.depth == pytest.approx(other.depth, abs=1e-12) and one.index("torus") == other.index("torus")


def test_names_are_any_that_can_be_hashed_and_objects_are_replaced():
    manager, box = obbtree.CollisionManager(), trimesh.creation.box()
    manager.add_object(7, box)
    manager.add_object(12, box, at(0.5))
    assert manager.in_collision_internal(return_names=True) == (True, {(7, 12)})
    manager.add_object(12, box, at(3))
    assert manager.in_collision_internal() is False
    assert manager.min_distance_internal(return_names=True) == (2.0, (7, 12))
    manager.remove_object(12)
    for call in (manager.remove_object, lambda name: manager.set_transform(name, at()), manager.min_distance_internal):
        with pytest.raises(ValueError, match="not in collision manager"):
            call(12)
    # As trimesh says where there is no pair.
    assert manager.min_distance_internal(return_names=True, return_data=True) == (sys.float_info.max, None, None)
    assert manager.min_distance_internal(7) == obbtree.CollisionManager().min_distance_single(box) == sys.float_info.max
    assert manager.min_distance_other(obbtree.CollisionManager(), return_names=True) == (sys.float_info.max, None)
    with pytest.raises(ValueError, match=r"\(4,4\)"):
        manager.add_object("bad", box, np.eye(3))


def test_what_cannot_be_changed_stays_as_it_was():
    manager, box, probe = obbtree.CollisionManager(), trimesh.creation.box(), trimesh.creation.box(extents=[0.1, 0.1, 0.1])
    before = manager.add_object("box", box)
    far = np.diag([2.0, 2.0, 2.0, 1.0])
    far[0, 3] = 1e305
    for change in (manager.add_object, lambda name, _, transform: manager.set_transform(name, transform)):
        for bad in (at(np.nan), at(1e305), far):
            with pytest.raises(ValueError):
                change("box", box, bad)
            assert manager._objs == {"box": before} and list(manager._numbered.values()) == [before]
            assert manager.min_distance_single(probe, at(2.05)) == pytest.approx(1.5)
            hit, data = manager.in_collision_single(probe, at(0.5), return_data=True)
            assert hit and data[0].depth == pytest.approx(0.05)

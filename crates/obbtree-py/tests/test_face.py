"""The face against numpy: brute force over triangles, shapes of what comes back, errors, threads, forks."""

import importlib.metadata
import os
import signal
import sys
import threading
import time
from fractions import Fraction

import numpy as np
import pytest

import obbtree


def cuboid(x=1.0, y=1.0, z=1.0):
    corners = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)]) - 0.5
    sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    faces = [face for a, b, c, d in sides for face in ([a, b, c], [a, c, d])]
    return obbtree.Mesh(corners * [x, y, z], faces)


def sphere(radius, n):
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, n), np.linspace(0, np.pi, n), indexing="ij")
    vertices = radius * np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1).reshape(-1, 3)
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate([np.stack([corner, corner + n, corner + 1], 1), np.stack([corner + 1, corner + n, corner + n + 1], 1)])
    return obbtree.Mesh(vertices, faces)


def test_the_version_is_that_of_the_package():
    assert obbtree.__version__ == importlib.metadata.version("obbtree")


def at(x=0.0, y=0.0, z=0.0):
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def turned(random, scale):
    rotation, _ = np.linalg.qr(random.standard_normal((3, 3)))
    pose = np.eye(4)
    pose[:3, :3] = rotation * np.sign(np.linalg.det(rotation))
    pose[:3, 3] = random.uniform(-scale, scale, 3)
    return pose


def test_verdicts_and_distances_of_boxes_are_those_of_intervals():
    random = np.random.default_rng(1)
    a, b = obbtree.Collider(cuboid(2, 3, 4)), obbtree.Collider(cuboid(1, 6, 2))
    half, poses, expected = (np.array([2, 3, 4]) + [1, 6, 2]) / 2, [], []
    for shift in random.integers(-40, 40, (200, 3)) / 8:
        gap = np.linalg.norm(np.maximum(np.abs(shift) - half, 0))
        poses.append(at(*shift))
        expected.append(gap)
        assert a.distance(b, poses[-1]).distance == pytest.approx(gap if gap else a.distance(b, poses[-1]).distance, abs=1e-12)
        assert not (gap > 0 and a.collides(b, poses[-1]))
    expected, poses = np.array(expected), np.array(poses)
    distances, points, faces = a.distance_each(b, poses)
    assert distances.shape == (200,) and points.shape == (200, 2, 3) and faces.shape == (200, 2)
    np.testing.assert_allclose(distances[expected > 0], expected[expected > 0], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(points[:, 0] - points[:, 1], axis=1), distances, atol=1e-12)
    assert 20 < (expected > 0).sum() < 190
    np.testing.assert_array_equal(a.collides_each(b, poses), [a.collides(b, pose) for pose in poses])


def pierced(face, triangle):
    """By how much the first corner of a triangle is through a face that both edges from it pierce, without rounding; None where one does not."""

    def minus(p, q):
        return [x - y for x, y in zip(p, q)]

    def cross(u, v):
        return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]

    def dot(u, v):
        return sum(x * y for x, y in zip(u, v))

    a, b = ([[Fraction(x) for x in corner] for corner in corners] for corners in (face, triangle))
    normal = cross(minus(a[1], a[0]), minus(a[2], a[0]))
    tip, *others = (dot(normal, minus(corner, a[0])) for corner in b)
    for height, corner in zip(others, b[1:]):
        if tip * height >= 0:
            return None
        at_plane = [x + tip / (tip - height) * (y - x) for x, y in zip(b[0], corner)]
        if any(dot(cross(minus(a[(i + 1) % 3], a[i]), minus(at_plane, a[i])), normal) < 0 for i in range(3)):
            return None
    return abs(float(tip)) / float(dot(normal, normal)) ** 0.5


def test_a_contact_that_is_told_as_clear_is_within_the_grid():
    face = [
        [602.1703757211612, -781.6711835234937, 119.47658570665794],
        [-788.9068135331718, -525.4344228242301, -871.0940918908693],
        [148.12838477098012, -780.9255001000847, -982.350524393145],
    ]
    tip = [
        [57.42539772309137, -742.3182604984545, -841.2527362258064],
        [32.555560134053906, -838.8681157272047, -829.0166898747663],
        [31.57828008115743, -838.4820676505966, -829.2556227628771],
    ]
    assert 7e-9 < pierced(face, tip) < 9e-9
    a, b = (obbtree.Collider(obbtree.Mesh(corners, [[0, 1, 2]])) for corners in (face, tip))
    for one, other in ((a, b), (b, a)):
        # A contact within the rounding of the vertices may be told as clear; `distance_below` at 2**-28 does not call it clear.
        assert not one.collides(other)
        assert one.distance_below(other, None, 2.0**-28 * np.abs(face).max()) is not None


def test_a_contact_at_a_matrix_that_is_not_quite_a_rotation_is_not_called_clear():
    single = turned(np.random.default_rng(6), 0.0)[:3, :3].astype(np.float32).astype(float)
    six_digits = np.array([[0.707107, -0.707107, 0], [0.707107, 0.707107, 0], [0, 0, 1]])
    told_as_clear = 0
    for matrix in (single, six_digits, np.eye(3) * (1 + 4.9e-7), np.eye(3) + 4.9e-7 * np.ones((3, 3))):
        for tip in 1000.0 * np.array([[1, 0, 0], [0.6, -0.8, 0], [1, 1, 1] / np.sqrt(3), [-0.48, 0.6, 0.64]]):
            # A face across the way to the tip, 1e-5 before where the matrix moves the tip.
            there = matrix @ tip
            out, aside = there / np.linalg.norm(there), np.linalg.svd(there[None])[2][1:]
            face = there - 1e-5 * out + np.array([[0, 1], [1, -1], [-1, -1]]) @ aside
            a, b = (obbtree.Collider(obbtree.Mesh(corners, [[0, 1, 2]])) for corners in (face, [tip, 0.99 * tip, 0.99 * tip]))
            pose, grid = np.eye(4), 2.0**-28 * max(np.abs(face).max(), np.abs(tip).max())
            pose[:3, :3] = matrix
            told_as_clear += a.distance_below(b, pose, grid) is None
            off = np.abs(matrix.T @ matrix - np.eye(3)).max()
            assert a.distance_below(b, pose, grid + 2 * off * 1000) is not None, (matrix, tip)
    # What the grid allows for is not enough.
    assert told_as_clear > 8


def test_contacts_are_the_pairs_of_faces_that_touch():
    a, b = obbtree.Collider(sphere(2, 12)), obbtree.Collider(sphere(1, 9))
    pose = at(2.5, 0.25, 0)
    contacts = a.contacts(b, pose)
    assert contacts.faces.dtype == np.uint32 and contacts.faces.shape == (len(contacts), 2) and contacts.points.shape == (len(contacts), 3)
    assert 10 < len(contacts) and np.all(np.diff(contacts.faces[:, 0].astype(int)) >= 0)
    assert np.all(np.linalg.norm(contacts.points, axis=1) < 2.01)
    single = {(i, j) for i, j in contacts.faces.tolist()}
    for i, j in list(single)[:5]:
        one = [obbtree.Collider(obbtree.Mesh(c.mesh.vertices, c.mesh.faces[[f]])) for c, f in ((a, i), (b, j))]
        assert one[0].collides(one[1], pose)
    assert len(a.contacts(b, pose, limit=3)) == 3
    assert a.contacts(b, at(9)).faces.shape == (0, 2) and a.contacts(b, at(9)).points.shape == (0, 3)


def test_paths_answer_as_single_queries_do():
    a, b = obbtree.Collider(sphere(2, 20)), obbtree.Collider(cuboid())
    path = obbtree.Path(a, b)
    for i in range(200):
        pose = at(0.02 * i, 0.1, 0)
        assert path.collides(pose) == a.collides(b, pose)
        assert path.distance(pose).distance == a.distance(b, pose).distance
    assert a.distance_below(b, pose, 0.5) is None
    assert a.distance_below(b, pose, 5.0).distance == a.distance(b, pose).distance


def test_no_pose_is_no_motion_and_any_unit_will_do():
    for unit in (1e-9, 1.0, 1e12):
        a = obbtree.Collider(obbtree.Mesh(cuboid().vertices * unit, cuboid().faces))
        assert a.collides(a) and not a.collides(a, at(1.001 * unit))
        assert a.distance(a, at(3 * unit)).distance == pytest.approx(2 * unit, rel=1e-9)


def test_meshes_come_back_and_other_objects_will_do():
    mesh = cuboid(1, 2, 3)
    assert mesh.vertices.shape == (8, 3) and mesh.faces.shape == (12, 3) and mesh.faces.dtype == np.uint32
    np.testing.assert_array_equal(mesh.bounds, [[-0.5, -1, -1.5], [0.5, 1, 1.5]])

    class Other:
        vertices, faces = mesh.vertices.tolist(), mesh.faces.astype(np.int16)

    collider = obbtree.Collider(Other())
    np.testing.assert_array_equal(collider.mesh.vertices, mesh.vertices)
    assert "12 faces" in repr(collider) and "8 vertices" in repr(mesh) and collider.bytes > 0


def fields_of_packed_records(array):
    records = np.zeros(len(array), dtype=[("before", np.uint8), ("it", array.dtype, array.shape[1:]), ("after", np.uint16)])
    records["it"] = array
    return records["it"]


def at_an_odd_offset(array):
    return np.frombuffer(b"\0" + array.tobytes() + b"\0", array.dtype, array.size, 1).reshape(array.shape)


def every_second(array):
    return np.repeat(array, 2, axis=0)[::2]


@pytest.mark.parametrize("view", [fields_of_packed_records, at_an_odd_offset, every_second])
def test_views_are_read_as_their_copies_are(view):
    random = np.random.default_rng(2)
    mesh, poses = sphere(2, 9), np.array([turned(random, 3) for _ in range(40)])
    for dtype in (np.int64, np.uint32, np.int32):
        seen = obbtree.Mesh(view(mesh.vertices), view(mesh.faces.astype(dtype)))
        np.testing.assert_array_equal(seen.vertices, mesh.vertices)
        np.testing.assert_array_equal(seen.faces, mesh.faces)
    a, b = obbtree.Collider(mesh), obbtree.Collider(cuboid())
    expected = a.distance_each(b, poses)[0]
    assert 5 < np.count_nonzero(expected) < 35
    np.testing.assert_array_equal(a.distance_each(b, view(poses))[0], expected)
    np.testing.assert_array_equal([a.distance(b, view(pose)).distance for pose in poses], expected)
    np.testing.assert_array_equal([a.distance(b, pose).distance for pose in view(poses)], expected)
    manager = obbtree.Manager()
    manager.insert("a", a)
    manager.insert("b", b)
    np.testing.assert_array_equal(manager.collides_each(["b"], view(poses[:, None])), expected == 0)


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3), int), "no triangle"),
        (np.zeros((3, 3)), np.zeros((0, 3), int), "no triangle"),
        ([[0, 0, np.nan]], [[0, 0, 0]], "not finite"),
        ([[0, 0, np.inf]], [[0, 0, 0]], "not finite"),
        ([[0, 0, 1e200]], [[0, 0, 0]], "farther than"),
        ([[0, 0, 0]], [[0, 0, 1]], "names vertex 1"),
        ([[0, 0, 0]], [[0, 0, -1]], "negative"),
        ([[0, 0]], [[0, 0, 0]], r"\(n, 3\)"),
        ([[0, 0, 0]], [[0, 0]], r"\(n, 3\)"),
    ],
)
def test_bad_meshes_raise(vertices, faces, message):
    with pytest.raises(ValueError, match=message):
        obbtree.Mesh(vertices, faces)


def test_bad_values_raise():
    with pytest.raises(TypeError, match="integers"):
        obbtree.Mesh([[0, 0, 0]], [[0.0, 0.0, 0.5]])
    a = obbtree.Collider(cuboid())
    for pose, message in [
        (np.eye(3), r"\(4, 4\)"),
        (np.eye(4) * 2, "not a rotation"),
        (np.diag([1.00001, 1.00001, 1.00001, 1]), "not a rotation"),
        (np.eye(4) + np.eye(4, k=1) * [0, 5e-5, 0, 0], "not a rotation"),
        (np.full((4, 4), np.nan), "not finite"),
        (at(1e308), "too far"),
    ]:
        with pytest.raises(ValueError, match=message):
            a.distance(a, pose)
    with pytest.raises(ValueError, match=r"\(n, 4, 4\)"):
        a.collides_each(a, np.eye(4))
    with pytest.raises(ValueError, match="limit is -1"):
        a.contacts(a, limit=-1)
    manager = obbtree.Manager()
    for contacts in (lambda: manager.contacts(limit=-3), lambda: manager.contacts_with(manager, limit=-3), lambda: a.contacts(a, limit=-3 * 10**40)):
        with pytest.raises(ValueError, match="limit is -3"):
            contacts()
    with pytest.raises(TypeError):
        a.contacts(a, limit=1.5)
    for limit in (2**63, 2**64, 10**40):
        assert len(a.contacts(a, limit=limit)) == len(a.contacts(a)) > 0
    nan = float("nan")
    for ask in (lambda: a.distance_below(a, None, nan), lambda: manager.near_pairs(nan), lambda: manager.near_pairs_with(manager, nan)):
        with pytest.raises(ValueError, match="length is nan"):
            ask()
    assert a.distance_below(a, None, float("inf")).distance == 0
    with pytest.raises(ValueError, match="pose 1"):
        a.collides_each(a, [np.eye(4), np.diag([1, 1, -1, 1])])
    assert a.collides_each(a, np.zeros((0, 4, 4))).shape == (0,)
    assert [part.shape for part in a.distance_each(a, np.zeros((0, 4, 4)))] == [(0,), (0, 2, 3), (0, 2)]


def ticks_during(work):
    """How often this thread runs while another one works."""
    done, ticks = threading.Event(), 0

    def run():
        work()
        done.set()

    interval = sys.getswitchinterval()
    sys.setswitchinterval(10.0)  # Who does not let go keeps the lock.
    try:
        thread = threading.Thread(target=run)
        thread.start()
        while not done.is_set():
            ticks += 1
            time.sleep(0.0005)
        thread.join()
    finally:
        sys.setswitchinterval(interval)
    return ticks


def test_a_query_lets_other_threads_run():
    a = obbtree.Collider(sphere(1, 200))
    poses = np.array([at(0.001 * i, 0.002, 0.003) for i in range(3000)])
    assert ticks_during(lambda: a.distance_each(a, poses)) > 5


def test_a_path_that_makes_a_tree_lets_other_threads_run():
    fine, large = obbtree.Collider(sphere(1, 400)), obbtree.Collider(cuboid(1e4, 1e4, 1e4))
    bytes_before = fine.bytes
    assert ticks_during(lambda: obbtree.Path(fine, large)) > 5
    assert fine.bytes > bytes_before


def ends_in_a_child(work):
    """Whether a forked child is through with its work within 30 s."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            work()
            code = 0
        finally:
            os._exit(code)
    end = time.monotonic() + 30
    while time.monotonic() < end:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return status == 0
        time.sleep(0.01)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return False


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_forked_child_builds_and_asks():
    a, large = obbtree.Collider(sphere(1, 20)), obbtree.Collider(cuboid(1e4, 1e4, 1e4))
    poses = np.array([at(0.02 * i) for i in range(200)])
    expected, manager = a.collides_each(a, poses), obbtree.Manager()
    manager.insert("a", a)
    manager.insert("b", a)

    def build():
        assert obbtree.Collider(sphere(1, 20)).collides(a)

    def each():
        np.testing.assert_array_equal(a.collides_each(a, poses), expected)
        assert np.all(a.distance_each(a, poses)[0][expected] == 0)
        np.testing.assert_array_equal(manager.collides_each(["b"], poses[:, None]), expected)

    def coarser():
        assert not a.collides(large) and obbtree.Path(a, large).distance(np.eye(4)).distance > 4998

    def in_threads():
        each()
        threads = [threading.Thread(target=work) for work in (build, each, each)]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]

    def again():
        each()
        assert ends_in_a_child(each)

    def changes():
        each()
        manager.set_pose("b", at(9))
        assert not manager.collides() and manager.nearest()[1].distance > 6
        manager.remove("b")
        assert path.distance(at()).distance == pytest.approx(inner.distance(outer).distance, rel=1e-12)

    inner, outer = obbtree.Collider(sphere(1, 40)), obbtree.Collider(sphere(2, 40))
    path, done = obbtree.Path(inner, outer), threading.Event()
    rows = np.tile(np.array([np.eye(4), at(2.5)])[:, None], (20000, 1, 1, 1))
    asks = (lambda: manager.collides_each(["b"], rows), lambda: path.distance(at()))

    def asked(ask):
        while not done.is_set():
            ask()

    for work in (build, each, coarser, in_threads, again, changes):
        assert ends_in_a_child(work), work.__name__
    threads = [threading.Thread(target=asked, args=(ask,)) for ask in asks]
    [thread.start() for thread in threads]
    try:
        for _ in range(10):
            time.sleep(0.02)
            assert ends_in_a_child(changes)
    finally:
        done.set()
        [thread.join() for thread in threads]
    each()

"""What is a solid, and what is refused."""

import numpy as np
import pytest
from test_face import at, cuboid, sphere, turned

import obbtree


def mesh(vertices, faces):
    return obbtree.Mesh(np.asarray(vertices, dtype=float), faces)


def depth(a, b, pose):
    overlap = obbtree.Convex(a).penetration(obbtree.Convex(b), pose)
    return None if overlap is None else overlap.depth


SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
# Both sides of a square, and of a triangle.
SHEET = [[0, 1, 2], [0, 2, 3], [1, 0, 3], [2, 1, 3]]
TWICE = [[0, 1, 2], [2, 1, 0]]


def two(a, b):
    return mesh(np.vstack([a.vertices, b.vertices]), np.vstack([a.faces, b.faces + len(a.vertices)]))


def dented():
    corners = cuboid().vertices.copy()
    corners[7] = [0, 0, 0.3]
    return mesh(corners, cuboid().faces)


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        (mesh(SQUARE, SHEET), "flat"),
        (mesh(np.float32(np.array(SQUARE) @ turned(np.random.default_rng(2), 1)[:3, :3]), SHEET), "flat"),
        (mesh([[0, 0, 0], [1, 1, 1], [3, 3, 3]], TWICE), "no face of the mesh has an area"),
        (mesh([[2, 3, 4]], [[0, 0, 0]] * 2), "not closed"),
        (two(cuboid(), mesh(cuboid().vertices + 3, cuboid().faces)), "several parts"),
        (two(cuboid(), cuboid()), "several parts"),
        (two(cuboid(), cuboid(3, 3, 3)), "several parts"),
        (mesh(cuboid().vertices, cuboid().faces[1:]), "not closed"),
        (dented(), "not convex"),
    ],
)
def test_what_is_no_solid_is_refused(shape, message):
    for unit in (1e-82, 1.0, 1e80):
        with pytest.raises(ValueError, match=message):
            obbtree.Convex(mesh(shape.vertices * unit, shape.faces))


def test_a_corner_is_above_a_face_that_is_not_beside_it():
    # Each corner is below the planes across the edges beside it: a ring of five that winds round twice, with a tip on both sides.
    angles = np.arange(5) * 4 * np.pi / 5
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(5)], axis=1)
    faces = [face for i in range(5) for face in ([i, (i + 1) % 5, 5], [(i + 1) % 5, i, 6])]
    with pytest.raises(ValueError, match="not convex"):
        obbtree.Convex(mesh(np.vstack([ring, [[0, 0, 1], [0, 0, -1]]]), faces))


def test_solids_of_any_size_are_as_deep_as_they_are():
    for unit in (1e-140, 1e-82, 1.0, 1e80, 1e140):
        a, b = (mesh(box.vertices * unit, box.faces) for box in (cuboid(2, 3, 4), cuboid(1, 6, 2)))
        assert depth(a, b, at(1.2 * unit)) == pytest.approx(0.3 * unit, rel=1e-12)
        assert depth(a, b, at(1.6 * unit)) is None
        # Edge across edge: the cube on its edge, turned about z by a quarter of a turn.
        tilt = np.array([[1, 0, 0], [0, 0.5**0.5, -(0.5**0.5)], [0, 0.5**0.5, 0.5**0.5]])
        quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
        cube = mesh(cuboid().vertices @ tilt.T * unit, cuboid().faces)
        pose = at(0, 0, (2**0.5 - 0.01) * unit)
        pose[:3, :3] = quarter
        assert depth(cube, cube, pose) == pytest.approx(0.01 * unit, rel=1e-9)
        pose[2, 3] = (2**0.5 + 0.01) * unit
        assert depth(cube, cube, pose) is None


def test_thin_solids_and_round_ones_and_what_winds_either_way_are_solids():
    assert depth(cuboid(1000, 1000, 0.01), cuboid(), at(0, 0, 0.5)) == pytest.approx(0.005)
    faces = cuboid().faces.copy()
    faces[::2] = faces[::2, ::-1]
    assert depth(mesh(cuboid().vertices, faces), cuboid(), at(0.75)) == pytest.approx(0.25)
    # Closed: the seam and the poles are the same corners.
    ball = sphere(1, 17)
    rounded, inverse = np.unique(np.round(ball.vertices, 9) + 0.0, axis=0, return_inverse=True)
    faces = inverse.ravel()[ball.faces]
    faces = faces[[len(set(face)) == 3 for face in faces]]
    single = mesh(np.float32(rounded), faces)
    assert depth(single, single, at(1.5)) == pytest.approx(0.5, abs=0.02)


def plate(dent):
    """A box of edge 1000 with a corner in the middle of its top, some way in."""
    corners = cuboid(1000, 1000, 1000).vertices
    top = [4, 5, 7, 6]
    faces = [face for face in cuboid().faces.tolist() if not set(face) <= set(top)]
    faces += [[i, j, 8] for i, j in zip(top, top[1:] + top[:1])]
    return mesh(np.vstack([corners, [0, 0, 500 - dent]]), faces)


def test_a_dent_makes_a_solid_no_larger_than_its_hull():
    random = np.random.default_rng(5)
    tip = mesh([[0, 0, 0], [10, 0, 90], [-10, 10, 90], [-10, -10, 90]], [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    for dent, pose in [(d, p) for d in (0.0, 1e-9, 1e-4, 0.004) for p in (np.eye(4), turned(random, 0.0), turned(random, 0.0))]:
        dented = plate(dent)
        solid = obbtree.Convex(mesh(dented.vertices @ pose[:3, :3].T, dented.faces))
        for gap in (0.002, 1e-4, -1e-4, -0.002):
            at_tip = pose @ at(0, 0, 500 + gap)
            overlap = solid.penetration(obbtree.Convex(tip), at_tip)
            assert (overlap is not None) == (gap < 0), (dent, gap)
            assert overlap is None or overlap.depth == pytest.approx(-gap, abs=1e-8)
            inside = solid.corner_inside(obbtree.Collider(tip), at_tip)
            assert (inside is not None) == (gap < 0), (dent, gap)


def test_corners_along_edges_hide_no_edge():
    # Turned, they are off their line by rounding: the hull has faces there that lean anywhere.
    random = np.random.default_rng(6)
    corners, faces = cuboid().vertices.tolist(), cuboid().faces.tolist()
    for _ in range(2):
        middle, parts = {}, []
        for a, b, c in faces:
            for side in (frozenset(side) for side in ((a, b), (b, c), (c, a))):
                if side not in middle:
                    middle[side] = len(corners)
                    corners.append(np.mean([corners[vertex] for vertex in side], axis=0))
            d, e, f = (middle[frozenset(side)] for side in ((a, b), (b, c), (c, a)))
            parts += [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
        faces = parts
    corners, edge = np.array(corners), np.eye(4)
    edge[:3, :3] = [[1, 0, 0], [0, 0.5**0.5, -(0.5**0.5)], [0, 0.5**0.5, 0.5**0.5]]
    across = np.array([[0.0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    for dtype in (np.float64, np.float32):
        for _ in range(20):
            turn, other = turned(random, 0.0), turned(random, 0.0)
            a, b = (mesh(dtype(corners @ (t @ edge)[:3, :3].T), faces) for t in (turn, other))
            for gap in (0.01, -0.01):
                pose = turn @ at(0, 0, 2**0.5 + gap) @ across @ other.T
                assert depth(a, b, pose) == (None if gap > 0 else pytest.approx(0.01, abs=1e-6))


def test_faces_without_area_hide_no_edge():
    # A cube on its edge. One of the faces beside its upper edge is divided at the middle of that edge; a triangle without area closes the gap.
    corners, faces = cuboid().vertices, [list(face) for face in cuboid().faces]
    start, end = (i for i in range(8) if corners[i][1] > 0 and corners[i][2] > 0)
    divided = next(face for face in faces if {start, end} <= set(face))
    third = next(vertex for vertex in divided if vertex not in (start, end))
    faces.remove(divided)
    faces += [[start, 8, third], [8, end, third], [start, end, 8]]
    tilt = np.array([[1, 0, 0], [0, 0.5**0.5, -(0.5**0.5)], [0, 0.5**0.5, 0.5**0.5]])
    slivered = mesh(np.vstack([corners, (corners[start] + corners[end]) / 2]) @ tilt.T, faces)
    plain = mesh(corners @ tilt.T, cuboid().faces)
    pose = at(0, 0, 2**0.5 - 0.01)
    pose[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    assert depth(plain, plain, pose) == pytest.approx(0.01)
    assert depth(slivered, plain, pose) == pytest.approx(0.01)
    pose[2, 3] = 2**0.5 + 0.01
    assert depth(slivered, plain, pose) is None

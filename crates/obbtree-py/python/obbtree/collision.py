"""A collision manager with the methods of trimesh.collision.CollisionManager, to stand in for it.

As there, convex meshes are solids: what is inside one collides with it, and two that overlap have a depth, which min_distance_* give as a negative
distance. All other meshes are surfaces; the distance of two that touch is 0, and that of one inside a solid. Names are hashable and can be sorted.
"""

from __future__ import annotations

import hashlib
import itertools
import sys
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._obbtree import Collider, Convex, Manager, Mesh, Nearest, Penetration

# The name of an object that is in no manager, as trimesh gives it.
EXTERNAL = "__external"
# Most contacts of a pair that are listed.
CONTACTS_PER_PAIR = 100_000
# Meshes whose trees are kept for when they come again.
KEPT = 64
# How far from orthogonal the rotation R of a rigid transform may be, as max|RᵀR - I|: what the engine takes for a rigid pose.
RIGID = 1e-6

Vector = NDArray[np.float64]
Names = tuple[Any, Any]
# The collider of a mesh, and the solid if there is one.
Shape = tuple[Collider, Convex | None]


class ContactData:
    """Two faces that touch, two convex solids that overlap, or a surface inside one."""

    def __init__(self, names: Names, faces: tuple[int, int], point: Vector, normal: Vector, depth: float) -> None:
        self.names = set(names)
        self._faces: dict[Any, int] = dict(zip(names, faces))
        self.point = point
        """A point of the contact, of shape (3,), in the world."""
        self.normal = normal
        """The direction, of shape (3,), in which the second object is to move to part them; zeros for a surface inside a solid.

        The second is the mesh that is asked about, the object of the other manager, or of two in one manager the one that was added later.
        """
        self.depth = depth
        """How far."""

    def index(self, name: Any) -> int:
        """The face of the object of that name."""
        return self._faces[name]


class DistanceData:
    """The nearest points of two objects; the deepest ones where convex solids overlap."""

    def __init__(self, names: Names, distance: float, points: NDArray[np.float64], faces: tuple[int, int]) -> None:
        self.names = set(names)
        self.distance = distance
        self._points: dict[Any, Vector] = dict(zip(names, points))
        self._faces: dict[Any, int] = dict(zip(names, faces))

    def index(self, name: Any) -> int:
        """The face of the object of that name."""
        return self._faces[name]

    def point(self, name: Any) -> Vector:
        """The point of the object of that name, of shape (3,), in the world."""
        return self._points[name]


class CollisionObject:
    """An object of a manager: its mesh as it was when it was added, and where it is."""

    def __init__(self, name: Any, mesh: Any, shape: Shape, transform: Vector) -> None:
        self.name = name
        self.vertices, self.faces = np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces)
        self.collider, self.convex = shape
        self.is_convex = bool(mesh.is_convex)
        self.transform = transform
        # Where the engine has it: its rotation is orthogonal within rounding.
        self.pose = transform


class CollisionManager:
    """Meshes by name, each with a transform. The methods are those of trimesh.collision.CollisionManager.

    Threads may ask at the same time while none changes an object, and change different objects at the same time while none asks. A query asks the engine
    several times: one that meets a change may raise KeyError, or answer about an object at two places.
    """

    def __init__(self) -> None:
        self._objs: dict[Any, CollisionObject] = {}
        # The objects by the names they have in the engine: numbers as text, whose order is that in which they came.
        self._numbered: dict[str, CollisionObject] = {}
        self._key_of: dict[Any, str] = {}
        # Taken in one step, so that no two threads have the same number.
        self._numbers = itertools.count()
        self._manager = Manager()
        self._kept: dict[bytes, Shape] = {}

    def add_object(self, name: Any, mesh: Any, transform: ArrayLike | None = None) -> CollisionObject:
        """Adds an object, or replaces the one of that name. `mesh` has vertices, faces and is_convex; later changes of it do not count."""
        matrix = _matrix(transform)
        item = CollisionObject(name, mesh, self._shape(mesh, matrix), matrix)
        key = f"{next(self._numbers):020}"
        self._manager.insert(key, item.collider, _pose(matrix))
        item.pose = self._manager.pose(key)
        # Only now: where the new one cannot be had, the one before stays.
        if name in self._objs:
            self.remove_object(name)
        self._objs[name] = self._numbered[key] = item
        self._key_of[name] = key
        return item

    def remove_object(self, name: Any) -> None:
        """Takes an object out."""
        self._known(name)
        key = self._key_of.pop(name)
        self._manager.remove(key)
        del self._objs[name], self._numbered[key]

    def set_transform(self, name: Any, transform: ArrayLike) -> None:
        """Moves an object to a transform, which replaces the one before."""
        item, matrix = self._known(name), _matrix(transform)
        key = self._key_of[name]
        if _is_rigid(matrix) and _is_rigid(item.transform):
            self._manager.set_pose(key, matrix)
        else:
            collider, convex = self._shape(item, matrix)
            self._manager.insert(key, collider, _pose(matrix))
            item.collider, item.convex = collider, convex
        item.transform, item.pose = matrix, self._manager.pose(key)

    def in_collision_single(
        self, mesh: Any, transform: ArrayLike | None = None, return_names: bool = False, return_data: bool = False
    ) -> Any:
        """Whether a mesh collides with any object; the set of their names; the list of ContactData."""
        other = self._of_one(mesh, transform)
        pairs = self._pairs(other, stop=not (return_names or return_data))
        names = {self._numbered[pair[0]].name for pair in pairs}
        return _answer(bool(pairs), names, self._data(pairs, other) if return_data else [], return_names, return_data)

    def in_collision_internal(self, return_names: bool = False, return_data: bool = False) -> Any:
        """Whether any pair of objects collides; the set of pairs of names, each sorted; the list of ContactData."""
        pairs = self._pairs(self, stop=not (return_names or return_data))
        names = {tuple(sorted((self._numbered[i].name, self._numbered[j].name))) for i, j in pairs}
        return _answer(bool(pairs), names, self._data(pairs, self) if return_data else [], return_names, return_data)

    def in_collision_other(
        self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False
    ) -> Any:
        """Whether any object collides with one of another manager; the set of pairs of names, ours first; the list of ContactData."""
        pairs = self._pairs(other_manager, stop=not (return_names or return_data))
        names = {(self._numbered[i].name, other_manager._numbered[j].name) for i, j in pairs}
        data = self._data(pairs, other_manager) if return_data else []
        return _answer(bool(pairs), names, data, return_names, return_data)

    def min_distance_single(
        self, mesh: Any, transform: ArrayLike | None = None, return_name: bool = False, return_data: bool = False
    ) -> Any:
        """The distance of a mesh from the nearest object, that object's name, and the DistanceData."""
        found = self._nearest(self._of_one(mesh, transform))
        name = None if found is None else self._numbered[found[0][0]].name
        return _distance(found, name, return_name, return_data)

    def min_distance_internal(
        self, name: Any | None = None, return_names: bool = False, return_data: bool = False
    ) -> Any:
        """The distance of the nearest pair of objects, or of the object nearest to `name`; the names, sorted; the DistanceData."""
        if name is not None:
            self._known(name)
        found = self._nearest(self, None if name is None else self._key_of[name])
        names = None if found is None else tuple(sorted(self._numbered[key].name for key in found[0]))
        return _distance(found, names, return_names, return_data)

    def min_distance_other(
        self, other_manager: CollisionManager, return_names: bool = False, return_data: bool = False
    ) -> Any:
        """The distance of the nearest pair of objects of both managers; the names, ours first; the DistanceData."""
        found = self._nearest(other_manager)
        names = None if found is None else (self._numbered[found[0][0]].name, other_manager._numbered[found[0][1]].name)
        return _distance(found, names, return_names, return_data)

    def _known(self, name: Any) -> CollisionObject:
        if name not in self._objs:
            raise ValueError(f"{name} not in collision manager!")
        return self._objs[name]

    def _shape(self, mesh: Any, matrix: Vector) -> Shape:
        """The shape of a mesh or an object. What a transform does beside moving is done to it."""
        linear = None if _is_rigid(matrix) else matrix[:3, :3]
        vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces)
        is_convex = bool(mesh.is_convex)
        parts = (vertices, faces) if linear is None else (vertices, faces, linear)
        # The same bytes are another mesh in other shapes or types, and another solid if only one is convex.
        kind = repr((is_convex, [(part.shape, part.dtype.str) for part in parts])).encode()
        key = hashlib.blake2b(kind + b"".join(np.ascontiguousarray(part).tobytes() for part in parts)).digest()
        kept = self._kept.get(key)
        if kept is not None:
            return kept
        if linear is not None:
            vertices = vertices @ linear.T
            # A mirrored face turns the other way round.
            faces = faces[:, ::-1] if np.linalg.det(linear) < 0.0 else faces
        shape = Mesh(vertices, faces)
        convex = None
        if is_convex:
            try:
                convex = Convex(shape)
            except ValueError:
                pass  # Not closed or not quite convex: a surface.
        # Other threads may do the same: each step is one call into the dictionary, and no lock is left in a forked child.
        for oldest in list(self._kept)[: 1 - KEPT]:
            self._kept.pop(oldest, None)
        return self._kept.setdefault(key, (Collider(shape), convex))

    def _of_one(self, mesh: Any, transform: ArrayLike | None) -> CollisionManager:
        """A manager of a mesh that is in none."""
        other = CollisionManager()
        other._kept = self._kept
        other.add_object(EXTERNAL, mesh, transform)
        return other

    def _pairs(self, other: CollisionManager, stop: bool) -> list[tuple[str, str]]:
        """The pairs that collide: those that touch, and those of which one is inside the other. If `stop`, some of them are enough."""
        inside = other is self
        touching = self._manager.colliding_pairs() if inside else self._manager.colliding_pairs_with(other._manager)
        if touching and stop:
            return touching
        near = self._manager.near_pairs() if inside else self._manager.near_pairs_with(other._manager)
        known = set(touching)
        return touching + [pair for pair in near if pair not in known and self._held(pair, other) is not None]

    def _held(self, pair: tuple[str, str], other: CollisionManager) -> tuple[tuple[int, int], Vector] | None:
        """Of two objects that do not touch, one inside the other, a convex solid: a corner of what is inside, and a face of each."""
        a, b = self._numbered[pair[0]], other._numbered[pair[1]]
        for outer, inner in ((a, b), (b, a)):
            found = None if outer.convex is None else outer.convex.corner_inside(inner.collider, _relative(outer, inner))
            if found is not None:
                face, vertex = found
                # Nothing touches: the outer one has no face to name.
                faces = (0, face) if inner is b else (face, 0)
                return faces, _moved(inner.pose, inner.collider.mesh.vertices[vertex])
        return None

    def _overlap(self, pair: tuple[str, str], other: CollisionManager) -> Penetration | None:
        """How deep two objects are in each other; None if they are apart or not both convex."""
        a, b = self._numbered[pair[0]], other._numbered[pair[1]]
        if a.convex is None or b.convex is None:
            return None
        return a.convex.penetration(b.convex, _relative(a, b))

    def _data(self, pairs: Iterable[tuple[str, str]], other: CollisionManager) -> list[ContactData]:
        contacts = None
        data = []
        for pair in pairs:
            a, b = self._numbered[pair[0]], other._numbered[pair[1]]
            names, pose = (a.name, b.name), a.pose
            overlap = self._overlap(pair, other)
            if overlap is not None:
                point = _moved(pose, np.mean(overlap.points, axis=0))
                normal = pose[:3, :3] @ np.asarray(overlap.normal)
                data.append(ContactData(names, overlap.faces, point, normal, overlap.depth))
                continue
            if contacts is None:
                found = (
                    self._manager.contacts(CONTACTS_PER_PAIR)
                    if other is self
                    else self._manager.contacts_with(other._manager, CONTACTS_PER_PAIR)
                )
                contacts = dict(found)
            if pair in contacts:
                touching = contacts[pair]
                normals, depths = _depths(a, b, touching.faces)
                rows = zip(touching.faces.tolist(), touching.points, normals, depths.tolist())
                data.extend(ContactData(names, (i, j), point, normal, depth) for (i, j), point, normal, depth in rows)
                continue
            held = self._held(pair, other)
            if held is not None:
                faces, corner = held
                data.append(ContactData(names, faces, corner, np.zeros(3), 0.0))
        return data

    def _nearest(self, other: CollisionManager, only: str | None = None) -> tuple[tuple[str, str], DistanceData] | None:
        """The nearest pair; of solids that overlap the deepest. None where there is no pair."""
        inside = other is self
        near = self._manager.near_pairs() if inside else self._manager.near_pairs_with(other._manager)
        if only is not None:
            near = [pair for pair in near if only in pair]
        best: tuple[tuple[str, str], DistanceData] | None = None
        for pair in near:
            overlap = self._overlap(pair, other)
            if overlap is not None and (best is None or -overlap.depth < best[1].distance):
                a, b = self._numbered[pair[0]], other._numbered[pair[1]]
                points = np.array([_moved(a.pose, point) for point in overlap.points])
                best = (pair, DistanceData((a.name, b.name), -overlap.depth, points, overlap.faces))
        if best is not None:
            return best
        found: tuple[tuple[str, str], Nearest] | None
        if only is not None:
            found = self._manager.nearest_to(only)
        else:
            found = self._manager.nearest() if inside else self._manager.nearest_with(other._manager)
        if found is None:
            return None

        def names(pair: tuple[str, str]) -> Names:
            return self._numbered[pair[0]].name, other._numbered[pair[1]].name

        pair, nearest = found
        # Only what touches is at 0 so far.
        for inner in near if nearest.distance > 0.0 else []:
            held = self._held(inner, other)
            if held is not None:
                faces, corner = held
                return inner, DistanceData(names(inner), 0.0, np.array([corner, corner]), faces)
        return pair, DistanceData(names(pair), nearest.distance, nearest.points, nearest.faces)


def _answer(first: Any, names: Any, data: Any, with_names: bool, with_data: bool) -> Any:
    answer = (first, *([names] if with_names else []), *([data] if with_data else []))
    return answer[0] if len(answer) == 1 else answer


def _distance(found: tuple[tuple[str, str], DistanceData] | None, names: Any, with_names: bool, with_data: bool) -> Any:
    """The answer about a nearest pair: as trimesh's, the largest number where there is no pair."""
    distance, data = (sys.float_info.max, None) if found is None else (found[1].distance, found[1])
    return _answer(distance, names, data, with_names, with_data)


def _matrix(transform: ArrayLike | None) -> Vector:
    matrix = np.eye(4) if transform is None else np.array(transform, dtype=np.float64)
    if matrix.shape != (4, 4):
        raise ValueError("transform must be (4,4)!")
    if not np.array_equal(matrix[3], [0.0, 0.0, 0.0, 1.0]):
        raise ValueError("the transform's last row is not 0 0 0 1; points are columns, so that a translation is in the last column")
    return matrix


def _is_rigid(matrix: Vector) -> bool:
    linear = matrix[:3, :3]
    return bool(np.abs(linear.T @ linear - np.eye(3)).max() < RIGID and np.linalg.det(linear) > 0.0)


def _pose(matrix: Vector) -> Vector:
    """Where an object is: the transform, or its translation where the rest has been done to the mesh."""
    if _is_rigid(matrix):
        return matrix
    pose = np.eye(4)
    pose[:3, 3] = matrix[:3, 3]
    return pose


def _moved(pose: Vector, point: ArrayLike) -> Vector:
    return np.asarray(pose[:3, :3] @ np.asarray(point) + pose[:3, 3])


def _relative(a: CollisionObject, b: CollisionObject) -> Vector:
    """The pose that takes coordinates of `b` to those of `a`."""
    of_a, of_b = a.pose, b.pose
    pose = np.eye(4)
    pose[:3, :3] = of_a[:3, :3].T @ of_b[:3, :3]
    pose[:3, 3] = of_a[:3, :3].T @ (of_b[:3, 3] - of_a[:3, 3])
    return pose


def _depths(a: CollisionObject, b: CollisionObject, faces: NDArray[np.uint32]) -> tuple[Vector, Vector]:
    """Of pairs of faces that touch, along the normal of either: how deep the other's deepest corner is below the plane; the lesser of both."""

    def corners(item: CollisionObject, numbers: NDArray[np.uint32]) -> Vector:
        mesh, pose = item.collider.mesh, item.pose
        return np.asarray(mesh.vertices[mesh.faces[numbers]] @ pose[:3, :3].T + pose[:3, 3])

    def below(plane: Vector, other: Vector) -> tuple[Vector, Vector]:
        normal = np.cross(plane[:, 1] - plane[:, 0], plane[:, 2] - plane[:, 0])
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        normal = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0.0)
        heights = np.einsum("nij,nj->ni", other - plane[:, :1], normal)
        return normal, np.maximum(-heights.min(axis=1), 0.0)

    first, second = corners(a, faces[:, 0]), corners(b, faces[:, 1])
    (normal_a, depth_a), (normal_b, depth_b) = below(first, second), below(second, first)
    of_a = (depth_a <= depth_b)[:, None]
    return np.where(of_a, normal_a, -normal_b), np.minimum(depth_a, depth_b)

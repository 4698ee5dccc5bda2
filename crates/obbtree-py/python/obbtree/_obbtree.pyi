from collections.abc import Sequence
from typing import Protocol, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self

__all__ = ["Collider", "Contacts", "Convex", "Manager", "Mesh", "Nearest", "Path", "Penetration", "__version__"]

__version__: str

class _HasMesh(Protocol):
    """Anything with vertices and faces, such as a trimesh.Trimesh."""

    @property
    def vertices(self) -> ArrayLike: ...
    @property
    def faces(self) -> ArrayLike: ...

@final
class Mesh:
    """Vertices, of shape (n, 3), and faces, integers of shape (m, 3). A surface: open, degenerate and duplicate faces are allowed.

    Raises ValueError when there is no face, a coordinate is not finite or beyond 2**500, a face names a missing vertex, or the largest coordinate is below
    2**-500 and not 0.
    """

    def __new__(cls, vertices: ArrayLike, faces: ArrayLike) -> Self: ...
    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @property
    def faces(self) -> NDArray[np.uint32]: ...
    @property
    def bounds(self) -> NDArray[np.float64]:
        """The smallest and the largest coordinates, of shape (2, 3)."""

@final
class Nearest:
    """The nearest points of two meshes."""

    @property
    def distance(self) -> float:
        """0.0 exactly where they touch."""
    @property
    def points(self) -> NDArray[np.float64]:
        """One point of each mesh, of shape (2, 3); in the frame of the first mesh, or of the manager's world."""
    @property
    def faces(self) -> tuple[int, int]:
        """The faces that the points lie on."""

@final
class Contacts:
    """Pairs of triangles that touch, sorted by faces."""

    @property
    def faces(self) -> NDArray[np.uint32]:
        """A face of each mesh, of shape (n, 2)."""
    @property
    def points(self) -> NDArray[np.float64]:
        """A point of each pair, of shape (n, 3); in the frame of the first mesh, or of the manager's world."""
    def __len__(self) -> int: ...

@final
class Collider:
    """A mesh with the tree that queries need. A mesh wholly inside another does not touch it.

    A pose, of shape (4, 4), takes the other mesh's coordinates to this one's, with the rotation nearest to its R. Raises ValueError when R has max|RᵀR - I|
    above 1e-6.
    """

    def __new__(cls, mesh: Mesh | _HasMesh) -> Self: ...
    @property
    def mesh(self) -> Mesh: ...
    @property
    def bytes(self) -> int:
        """Memory that it holds."""
    def collides(self, other: Collider, pose: ArrayLike | None = None) -> bool:
        """Whether the meshes share a point."""
    def contacts(self, other: Collider, pose: ArrayLike | None = None, limit: int | None = None) -> Contacts:
        """The pairs of triangles that touch, at most `limit` of them."""
    def distance(self, other: Collider, pose: ArrayLike | None = None) -> Nearest:
        """How far the meshes are apart, and where."""
    def distance_below(self, other: Collider, pose: ArrayLike | None, limit: float) -> Nearest | None:
        """The distance where it is below `limit`; None, and sooner known, where it is not."""
    def collides_each(self, other: Collider, poses: ArrayLike) -> NDArray[np.bool_]:
        """`collides` at poses of shape (n, 4, 4), on all cores."""
    def distance_each(
        self, other: Collider, poses: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.uint32]]:
        """`distance` at poses of shape (n, 4, 4), on all cores: distances (n,), points (n, 2, 3), faces (n, 2)."""

@final
class Path:
    """Two colliders along a path: the same answers, sooner where a pose is near the one before. Threads that ask at the same time do not wait for each other."""

    def __new__(cls, a: Collider, b: Collider) -> Self: ...
    def collides(self, pose: ArrayLike) -> bool: ...
    def distance(self, pose: ArrayLike) -> Nearest: ...

@final
class Manager:
    """Named colliders with poses in one world, and the pairs of them that are not asked about.

    A pose takes coordinates of the object to those of the world; what is no rigid motion is refused as by Collider. Names that are not there raise KeyError,
    but not where pairs are ignored. A query answers about the objects as they are when it is asked; changes by other threads do not wait for it.
    """

    def __new__(cls) -> Self: ...
    def insert(self, name: str, collider: Collider, pose: ArrayLike | None = None) -> None:
        """Adds an object, or replaces the one of that name."""
    def remove(self, name: str) -> Collider:
        """Takes an object out. Ignored pairs with its name stay ignored, also for a later object of that name."""
    def set_pose(self, name: str, pose: ArrayLike) -> None: ...
    def pose(self, name: str) -> NDArray[np.float64]: ...
    def collider(self, name: str) -> Collider: ...
    def ignore(self, name: str, other: str) -> None:
        """Stops asking about a pair, by its names in any order. There need not be such objects yet."""
    def consider(self, name: str, other: str) -> None:
        """Asks about an ignored pair again."""
    def is_ignored(self, name: str, other: str) -> bool: ...
    @property
    def names(self) -> list[str]: ...
    def __len__(self) -> int: ...
    def __contains__(self, key: str, /) -> bool: ...
    def collides(self) -> bool: ...
    def colliding_pairs(self) -> list[tuple[str, str]]: ...
    def contacts(self, limit: int | None = None) -> list[tuple[tuple[str, str], Contacts]]:
        """The triangles that touch, at most `limit` of a pair of objects."""
    def near_pairs(self, reach: float = 0.0) -> list[tuple[str, str]]:
        """Pairs of objects whose boxes along the axes of the world are at most `reach` apart."""
    def nearest(self) -> tuple[tuple[str, str], Nearest] | None: ...
    def nearest_to(self, name: str) -> tuple[tuple[str, str], Nearest] | None: ...
    def collides_with(self, other: Manager) -> bool: ...
    def colliding_pairs_with(self, other: Manager) -> list[tuple[str, str]]: ...
    def contacts_with(self, other: Manager, limit: int | None = None) -> list[tuple[tuple[str, str], Contacts]]: ...
    def near_pairs_with(self, other: Manager, reach: float = 0.0) -> list[tuple[str, str]]: ...
    def nearest_with(self, other: Manager) -> tuple[tuple[str, str], Nearest] | None: ...
    def collides_each(self, names: Sequence[str], poses: ArrayLike) -> NDArray[np.bool_]:
        """`collides` at many places of some objects, on all cores: `poses` has shape (n, len(names), 4, 4)."""

@final
class Penetration:
    """How deep two convex solids penetrate."""

    @property
    def depth(self) -> float:
        """The least motion that parts them."""
    @property
    def normal(self) -> list[float]:
        """Its direction for the second solid, in the frame of the first."""
    @property
    def points(self) -> list[list[float]]:
        """The deepest point of each, in the frame of the first."""
    @property
    def faces(self) -> tuple[int, int]: ...

@final
class Convex:
    """A closed convex mesh in one part as a solid: the convex hull of its corners, within 2**-25 of its size. Faces may wind either way round, and have no area.

    Raises ValueError when the mesh is open, in several parts, flat within 2**-22 of its size, or has a corner above a face by more than 1e-5 of it. Meant for
    solids of up to some thousand faces: it is made in time in proportion to faces times corners.
    """

    def __new__(cls, mesh: Mesh | _HasMesh) -> Self: ...
    def penetration(self, other: Convex, pose: ArrayLike | None = None) -> Penetration | None:
        """How deep the solids penetrate; None where they are apart. Takes time in proportion to the edges of one times those of the other."""
    def contains_corner_of(self, collider: Collider, pose: ArrayLike | None = None) -> bool:
        """Whether any corner of a mesh is inside or on the solid."""
    def corner_inside(self, collider: Collider, pose: ArrayLike | None = None) -> tuple[int, int] | None:
        """The first corner of a mesh that is inside or on the solid, as a face that has it and its vertex."""

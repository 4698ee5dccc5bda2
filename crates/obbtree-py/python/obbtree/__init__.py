"""Exact collision and distance queries between triangle meshes.

Lengths have any unit, the same for all meshes that meet. A pose is a 4 x 4 matrix, a rotation and a translation, that takes column vectors of the other
mesh's frame to this one's; without one the frames are the same. A pose is refused when its rotation R has max|RᵀR - I| above 1e-6: single precision leaves
about 1e-7. Touching counts as contact. Bad meshes, poses and limits raise ValueError, faces that are not integers TypeError. Queries run without the
interpreter's lock.

Verdicts are exact for the vertices as the engine holds them: rounded to 2**-30 of the larger mesh's largest coordinate or finer, before and after they are
moved. Meshes that touch, or miss each other, by less than that may be told the other way round. To be sure that they are apart, ask `distance_below` with
2**-28 of that coordinate as the limit. The engine takes the rotation nearest to a pose's R: where R is not orthogonal within double precision (six digits,
float32), add 2 max|RᵀR - I| times the distance of the other mesh's farthest vertex from its origin to the limit.
"""

from ._obbtree import Collider, Contacts, Convex, Manager, Mesh, Nearest, Path, Penetration, __version__
from .collision import CollisionManager, ContactData, DistanceData

__all__ = [
    "Collider",
    "CollisionManager",
    "ContactData",
    "Contacts",
    "Convex",
    "DistanceData",
    "Manager",
    "Mesh",
    "Nearest",
    "Path",
    "Penetration",
    "__version__",
]

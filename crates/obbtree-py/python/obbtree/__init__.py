"""Exact collision and distance queries between triangle meshes.

Lengths have any unit, the same for all meshes that meet. A pose is a 4 x 4 matrix, a rotation and a translation, that takes column vectors of the other
mesh's frame to this one's; without one the frames are the same. Touching counts as contact, and rounding never changes a verdict. Bad meshes, poses
and limits raise ValueError, faces that are not integers TypeError. Queries run without the interpreter's lock.
"""

from ._obbtree import Collider, Contacts, Convex, Manager, Mesh, Nearest, Path, Penetration
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
]

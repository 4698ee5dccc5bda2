"""A gripper above a table: what touches, how near it is, many places at once, and a path.

Run it with `python examples/cell.py`, or cell by cell in an editor that knows `# %%`.
"""

# %% Meshes are arrays of vertices and faces, in any unit; here metres.
import numpy as np

import obbtree


def cuboid(x, y, z):
    corners = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)]) - 0.5
    sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    faces = [face for a, b, c, d in sides for face in ([a, b, c], [a, c, d])]
    return obbtree.Mesh(corners * [x, y, z], faces)


def at(x, y, z):
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


# %% A collider is a mesh and its tree; a pose takes the other mesh to this one's frame.
part = obbtree.Collider(cuboid(0.06, 0.06, 0.06))
finger = obbtree.Collider(cuboid(0.02, 0.02, 0.1))
print(part.collides(finger, at(0.0395, 0, 0.05)), part.collides(finger, at(0.041, 0, 0.05)))
print(part.distance(finger, at(0.05, 0, 0.05)))
print(part.contacts(finger, at(0.0395, 0, 0.05), limit=3).faces)

# %% A manager names objects and knows which pairs may touch.
cell = obbtree.Manager()
cell.insert("table", obbtree.Collider(cuboid(1.2, 0.8, 0.05)), at(0, 0, -0.025))
cell.insert("part", part, at(0.2, 0.1, 0.03))
cell.insert("finger", finger, at(0.245, 0.1, 0.08))
cell.ignore("part", "table")
print(cell.colliding_pairs(), cell.nearest())

# %% Many places of an object at once, on all cores.
heights = np.array([[at(0.245, 0.1, 0.08 - 0.001 * i)] for i in range(60)])
print("first collision at step", int(np.argmax(cell.collides_each(["finger"], heights))))

# %% Poses in order help one another.
path = obbtree.Path(part, finger)
print(min(path.distance(at(0.045, 0, 0.1 - 0.0005 * i)).distance for i in range(200)))

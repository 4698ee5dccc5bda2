"""Poses of a URDF robot's parts along a joint path: for robots with more joints than a program has axes."""

import csv
import math
import xml.etree.ElementTree as ElementTree

IDENTITY = [[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 1.0, 0]]


def times(a, b):
    """The product of two rigid motions, given as the upper three rows of their matrices."""
    return [[sum(a[i][k] * b[k][j] for k in range(3)) + (a[i][3] if j == 3 else 0) for j in range(4)] for i in range(3)]


def turn(axis, angle):
    """A turn about an axis through the origin (Rodrigues' formula)."""
    length = math.sqrt(sum(x * x for x in axis))
    x, y, z = (component / length for component in axis)
    c, s = math.cos(angle), math.sin(angle)
    d = 1 - c
    return [
        [c + x * x * d, x * y * d - z * s, x * z * d + y * s, 0],
        [y * x * d + z * s, c + y * y * d, y * z * d - x * s, 0],
        [z * x * d - y * s, z * y * d + x * s, c + z * z * d, 0],
    ]


def shift(x, y, z):
    return [[1.0, 0, 0, x], [0, 1.0, 0, y], [0, 0, 1.0, z]]


def numbers(text):
    return [float(word) for word in text.split()]


def origin(element):
    """`<origin>` of a URDF element, metres and radians (fixed axes x, y, z)."""
    found = element.find("origin")
    if found is None:
        return IDENTITY
    roll, pitch, yaw = numbers(found.get("rpy", "0 0 0"))
    rotation = times(times(turn((0, 0, 1), yaw), turn((0, 1, 0), pitch)), turn((1, 0, 0), roll))
    return times(shift(*numbers(found.get("xyz", "0 0 0"))), rotation)


class Robot:
    """The joints of a URDF file."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            root = ElementTree.fromstring(file.read().strip())
        self.joints = [joint for joint in root.findall("joint") if joint.find("parent") is not None]
        self.visuals = {link.get("name"): link.findall("visual") for link in root.findall("link")}

    def poses(self, values, base=IDENTITY):
        """The pose of every link in the world, metres; joints that `values` (radians, metres) does not name stand at zero."""
        children = {joint.find("child").get("link") for joint in self.joints}
        poses = {name: base for name in self.visuals if name not in children}
        waiting = list(self.joints)
        while waiting:
            ready = [joint for joint in waiting if joint.find("parent").get("link") in poses]
            if not ready:
                raise ValueError("a joint hangs on a link that nothing carries")
            for joint in ready:
                moved = times(poses[joint.find("parent").get("link")], origin(joint))
                value = values.get(joint.get("name"), 0.0)
                if joint.get("type") != "fixed" and value:
                    axis = numbers(joint.find("axis").get("xyz"))
                    slide = shift(*(value * component for component in axis))
                    moved = times(moved, slide if joint.get("type") == "prismatic" else turn(axis, value))
                poses[joint.find("child").get("link")] = moved
            waiting = [joint for joint in waiting if joint not in ready]
        return poses

    def visual(self, link):
        """Where the first mesh of a link stands in the link's frame."""
        return origin(self.visuals[link][0])


def between(keys, steps):
    """Joint values at `steps` places from each key to the next, and at the last; a key names the joints that it moves."""
    now = {}
    for key in keys:
        target = {**now, **key}
        start = {**{name: 0.0 for name in target}, **now}
        for step in range(steps):
            yield {name: start[name] + (target[name] - start[name]) * step / steps for name in target}
        now = target
    yield now


def record(path, frames):
    """Writes frames, each a map from part to pose (metres), as the poses of a scene (mm)."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["frame", "part"] + [f"m{i}{j}" for i in range(3) for j in range(4)])
        for frame, poses in enumerate(frames):
            for part, pose in poses.items():
                cells = [f"{pose[i][j] * (1000 if j == 3 else 1):.9f}" for i in range(3) for j in range(4)]
                writer.writerow([frame, part, *cells])

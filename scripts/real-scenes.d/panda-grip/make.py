import math

from robot import Robot, between, record, times

arm = Robot("panda.urdf")
PARTS = {
    "link5": "panda_link5", "link6": "panda_link6", "link7": "panda_link7", "hand": "panda_hand",
    "left-finger": "panda_leftfinger", "right-finger": "panda_rightfinger",
}


def key(j1, j2, j4, j6, grip, j7=45.0):
    angles = {1: j1, 2: j2, 4: j4, 6: j6, 7: j7}
    return {**{f"panda_joint{n}": math.radians(a) for n, a in angles.items()}, "panda_finger_joint1": grip, "panda_finger_joint2": grip}


keys = [
    key(-35, 20, -110, 130, 0.04), key(0, 20, -110, 130, 0.04), key(0, 34, -104, 138, 0.04),  # above the part, down to it
    key(0, 34, -104, 138, 0.0145), key(0, 34, -104, 138, 0.006), key(0, 34, -104, 138, 0.04),  # gripped, squeezed, let go
    key(0, 41, -100, 142, 0.04), key(0, 24, -108, 132, 0.02), key(9, 33, -104, 138, 0.03, 20.0),  # into the table, up, askew
    key(25, 33, -104, 138, 0.03),
]
record("poses.csv", ({part: times(poses[link], arm.visual(link)) for part, link in PARTS.items()} for poses in map(arm.poses, between(keys, 60))))

from robot import Robot, between, record, shift, times, turn

hand = Robot("urdf/allegro_right_hand.urdf")
PARTS = {
    "palm": "palm_link", "index-2": "link_2.0", "index-3": "link_3.0", "index-tip": "link_3.0_tip",
    "middle-2": "link_6.0", "middle-tip": "link_7.0_tip", "thumb-1": "link_13.0", "thumb-2": "link_14.0", "thumb-3": "link_15.0", "thumb-tip": "link_15.0_tip",
}


def fist(bend, curl, thumb, spread=0.0):
    keys = {f"joint_{4 * finger + joint}.0": angle for finger in range(3) for joint, angle in ((0, spread), (1, bend), (2, curl), (3, curl * 0.8))}
    return {**keys, "joint_12.0": 0.263 + thumb, "joint_13.0": 0.4 * thumb, "joint_14.0": 0.6 * thumb, "joint_15.0": 0.6 * thumb}


keys = [fist(0, 0, 0), fist(0.5, 0.4, 0.5), fist(0.8, 0.7, 0.9), fist(1.0, 1.0, 1.13), fist(0.7, 0.5, 0.9, 0.2), fist(0.9, 1.2, 1.1, -0.2), fist(0, 0, 0)]
frames = list(between(keys, 70))


def grasp():
    for number, values in enumerate(frames):
        # The hand comes to the valve while the fingers begin to close, and turns about it at the end.
        near = min(1.0, number / 120)
        base = times(shift(-0.06 + 0.06 * near, 0, 0), turn((0, 0, 1), 0.5 * max(0.0, number / len(frames) - 0.6)))
        poses = hand.poses(values, base)
        yield {part: times(poses[link], hand.visual(link)) for part, link in PARTS.items()}


record("poses.csv", grasp())

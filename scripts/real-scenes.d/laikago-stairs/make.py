import math

from robot import Robot, between, record, shift, times

robot = Robot("laikago_toes_zup.urdf")
PARTS = {"chassis": "chassis", "hip": "FR_hip_motor", "thigh": "FR_upper_leg", "shank": "FR_lower_leg", "rear-thigh": "RR_upper_leg", "rear-shank": "RR_lower_leg"}
LEGS = ("FR", "RR")


def stance(front, rear, knee_front, knee_rear):
    angles = {"FR": (front, knee_front), "RR": (rear, knee_rear)}
    return {
        f"{leg}_{joint}": math.radians(angle)
        for leg in LEGS
        for joint, angle in (("upper_leg_2_hip_motor_joint", angles[leg][0]), ("lower_leg_2_upper_leg_joint", angles[leg][1]))
    }


keys = [stance(0, 0, 0, 0), stance(-45, 10, -20, 0), stance(-35, 15, 10, 5), stance(-20, 0, 15, -10), stance(10, -40, 0, -20), stance(20, -25, -30, 10)]
frames = list(between(keys, 80))


def walk():
    for number, values in enumerate(frames):
        # The body goes forward and up the stairs while the legs swing, and sinks at the end.
        along = number / len(frames)
        poses = robot.poses(values, shift(0.45 * along, 0, 0.44 + 0.1 * along - 0.12 * max(0, along - 0.75)))
        yield {part: times(poses[link], robot.visual(link)) for part, link in PARTS.items()}


record("poses.csv", walk())

import csv
import math

from bd_warehouse.gear import HelicalGear, SpurGear

from cad import write

MODULE, PINION, WHEEL, DISTANCE = 2, 17, 31, 48.0
write("pinion", SpurGear(MODULE, PINION, 20, 14, root_fillet=0.5))
write("wheel", SpurGear(MODULE, WHEEL, 20, 12, root_fillet=0.5))
write("idler", HelicalGear(MODULE, 23, 20, 12, 10))


def row(frame, part, angle, x, y, z=0.0):
    return [f"{frame}", part, f"{math.cos(angle / 2):.12f}", 0, 0, f"{math.sin(angle / 2):.12f}", f"{x:.9f}", f"{y:.9f}", f"{z:.9f}"]


frames = []
# In mesh with 0.12 mm more than the nominal distance, so that flanks clear; then out of phase by up to half a pitch; then drawn apart and along.
for step in range(260):
    turn = 2 * math.pi / WHEEL * step / 20
    phase = 0 if step < 120 else math.pi / PINION * (step - 120) / 140
    frames.append((turn, phase, DISTANCE + 0.12, 0.0))
for step in range(60):
    frames.append((0.0, 0.0, DISTANCE + 0.12 + 0.12 * step, 0.0))
for step in range(60):
    frames.append((0.0, 0.0, DISTANCE + 0.12, 0.3 * step))
with open("poses.csv", "w", newline="", encoding="utf-8") as file:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow("frame,part,qw,qx,qy,qz,tx,ty,tz".split(","))
    for frame, (turn, phase, distance, along) in enumerate(frames):
        writer.writerow(row(frame, "wheel", turn, 0, 0))
        # A gap of the pinion faces a tooth of the wheel when both stand at zero: 17 teeth have none opposite their first.
        writer.writerow(row(frame, "pinion", -turn * WHEEL / PINION + phase, distance, 0, along))
        writer.writerow(row(frame, "idler", turn * WHEEL / 23, -(MODULE * (WHEEL + 23) / 2 + 1.2), 0))

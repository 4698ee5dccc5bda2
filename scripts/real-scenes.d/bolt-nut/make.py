import csv
import math

from bd_warehouse.fastener import HexHeadScrew, HexNut

from cad import write

PITCH = 1.75
write("bolt", HexHeadScrew("M12-1.75", 40, "iso4017", simple=False))
write("nut", HexNut("M12-1.75", "iso4032", simple=False))

with open("poses.csv", "w", newline="", encoding="utf-8") as file:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow("frame,part,qw,qx,qy,qz,tx,ty,tz".split(","))
    frame = 0

    def put(turn, x, z):
        global frame
        writer.writerow([frame, "nut", f"{math.cos(turn / 2):.12f}", 0, 0, f"{math.sin(turn / 2):.12f}", f"{x:.9f}", 0, f"{z:.9f}"])
        frame += 1

    # Brought up below the end of the bolt, screwed on by 8 turns, pressed along against the flanks, brought off sideways.
    for step in range(60):
        put(0, 0, -70 + step / 60 * 18)
    for step in range(320):
        turn = 2 * math.pi * step / 40
        put(turn, 0, -52 + PITCH * turn / (2 * math.pi))
    for step in range(40):
        put(0, 0, -38 + PITCH * step / 40)
    for step in range(60):
        put(0, 0.05 * step**1.5, -60)

from bd_warehouse.fastener import ChamferedWasher, HexNutWithFlange, SocketHeadCapScrew
from build123d import Box, Cylinder, GridLocations, Pos

from cad import write

screw = SocketHeadCapScrew("M8-1.25", 30, simple=False)
washer = ChamferedWasher("M8", "iso7090")
write("screws", *[Pos(*place.position) * Pos(0, 0, 1.7) * screw for place in GridLocations(50, 40, 4, 3)])
write("washers", *[Pos(*place.position) * washer for place in GridLocations(50, 40, 4, 3)])
plate = Pos(0, 0, -12) * Box(220, 140, 24)
for place in GridLocations(50, 40, 4, 3):
    plate -= Pos(*place.position) * Cylinder(4.5, 100)
for place in GridLocations(25, 20, 8, 6):
    plate -= Pos(*place.position) * Pos(0, 0, 0) * Cylinder(3, 12)
write("plate", plate)
write("socket", HexNutWithFlange("M12-1.75", "din1665", simple=False))

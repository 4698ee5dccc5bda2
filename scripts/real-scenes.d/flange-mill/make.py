from bd_warehouse.fastener import HexHeadScrew
from bd_warehouse.flange import WeldNeckFlange
from build123d import PolarLocations

from cad import write

write("flange", WeldNeckFlange("3", 300))
screw = HexHeadScrew("M20-2.5", 60, "iso4017", simple=False)
# Every second hole of the bolt circle holds the flange down.
write("screws", *[place * screw for place in PolarLocations(84.15, 4)])

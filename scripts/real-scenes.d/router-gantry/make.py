from bd_warehouse.fastener import SocketHeadCapScrew
from bd_warehouse.open_builds import CBeamEndMount, CBeamLinearRail, RouterSpindleMount, StepperMotor, XLargeCBeamGantry
from build123d import Axis, Box, Compound, Cylinder, GridLocations, Pos, Rot

from cad import write

write("rails", *[Pos(0, y, -40) * Rot(0, 90, 0) * CBeamLinearRail(400) for y in (-180, 180)])
write("bridge", Pos(0, -200, 0) * Rot(-90, 0, 0) * CBeamLinearRail(400), chord_mm=0.05)
write("mount", RouterSpindleMount(), chord_mm=0.05)
write("motor", StepperMotor("Nema23"), chord_mm=0.05)
screw = SocketHeadCapScrew("M8-1.25", 20, simple=False)
clamps = [place * Compound(children=[Pos(0, 0, 6) * Box(40, 16, 12), Pos(8, 0, 12) * screw]) for place in GridLocations(180, 120, 2, 2)]
write("clamps", *clamps, chord_mm=0.05)
write("gantry", XLargeCBeamGantry(4), chord_mm=0.2, angle_rad=0.5)

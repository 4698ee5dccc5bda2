from bd_warehouse.bearing import SingleRowDeepGrooveBallBearing, SingleRowTaperedRollerBearing
from build123d import Box, Cylinder, Pos

from cad import write

# A tapered bearing among 43000 triangles, a ball bearing among 72000: rings, cages and rolling bodies as separate shells.
write("bearing", SingleRowTaperedRollerBearing("M20-42-15"), chord_mm=0.05, angle_rad=0.2)
write("small-bearing", SingleRowDeepGrooveBallBearing("M10-26-8"), chord_mm=0.05, angle_rad=0.25)
housing = Box(90, 60, 40) - Pos(-20, 0, 8) * Cylinder(21.05, 30) - Pos(25, 0, 14) * Cylinder(13.05, 14) - Cylinder(3, 100)
write("housing", housing)

from bd_warehouse.gear import Worm, WormWheel
from bd_warehouse.sprocket import Sprocket

from cad import write

write("worm", Worm(2, 1, 10, 40))
write("wheel", WormWheel(2, 30, 16))
write("sprocket", Sprocket(24, thickness=3, bolt_circle_diameter=50, num_mount_bolts=4, mount_bolt_diameter=5, bore_diameter=12))

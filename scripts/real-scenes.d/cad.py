"""Writes build123d's solids as STL, at one fineness for all scenes."""

from build123d import Compound, export_stl

CHORD_MM = 0.02
ANGLE_RAD = 0.15


def write(name, *solids, chord_mm=CHORD_MM, angle_rad=ANGLE_RAD):
    """Writes the solids, several as one body, to NAME.stl in the current folder."""
    shape = solids[0] if len(solids) == 1 else Compound(children=list(solids))
    if not export_stl(shape, f"{name}.stl", tolerance=chord_mm, angular_tolerance=angle_rad):
        raise RuntimeError(f"{name}.stl cannot be written")

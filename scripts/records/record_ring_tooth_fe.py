"""Compliance of rings with inner teeth by plane finite elements, for tests/gears/ring_teeth.rs.

    python -m venv fe && fe/bin/pip install gmsh==4.15.* numpy scipy
    fe/bin/python scripts/records/record_ring_tooth_fe.py > tests/data/ring-tooth-fe.toml

A whole ring, fixed at its outer diameter, as gears are fixed at their bores in record_tooth_fe.py.
The root fillets are arcs. The loads are at the points where a pinion touches.
"""

from math import atan, cos, pi, sin, sqrt, tan

import gmsh
import numpy as np
from record_tooth_fe import ALPHA, DEDENDUM, FINE, MARGIN, PATCH, TIP, Gear, compliance

HEADER = """\
# Made by scripts/records/record_ring_tooth_fe.py: whole rings in plane finite elements, held all
# round at the outer diameter. Lengths in m, angles in rad; rack 1 / 1.25 / 0.38, 20 degrees, root
# fillets arcs of 0.38 modules or what fits; Poisson's ratio 0.3. Profile shifts are positive where
# they make teeth thicker.
#
# plane: of stress or of strain.
# roll: roll angles of the contact on the ring's flank, tan of the pressure angle there.
# own: displacement at the loaded tooth, along the force, of the point where the force's line
#   crosses the tooth's centre line, under a unit force per unit width normal to the flank, the
#   contact's own indentation thus left out; times E.
# coupling: the same displacement at the tooth whose flank is in contact a base pitch further
#   towards its root (along that tooth's own line of force and on its own centre line), for the
#   first of the roll angles, as many as leave that contact on the flank.
# mesh_error: largest relative change of [own, coupling] from a mesh with elements and chords of the
#   flanks twice as long to the one recorded.
# patch_error: largest relative change of [own, coupling] where the loaded stretch is halved."""


class Ring(Gear):
    """Inner teeth, and a pinion with its teeth, profile shift, tip diameter and centre distance."""

    inner = True

    def __init__(self, teeth, module, outer, shift, tip_diameter, pinion):
        self.teeth, self.module, self.bore, self.shift = teeth, module, outer, shift
        self.pitch = module * teeth / 2
        self.base = self.pitch * cos(ALPHA)
        self.root = self.pitch + module * (DEDENDUM - shift)
        self.tip = sqrt((tip_diameter / 2 / self.base) ** 2 - 1)
        # Half of a space on the base circle, and half of a tooth.
        space = (pi / 2 - 2 * shift * tan(ALPHA)) / teeth + tan(ALPHA) - ALPHA
        self.half = space - pi / teeth

        def centre(radius):
            along = sqrt(((self.root - radius) / self.base) ** 2 - 1)
            form = along + radius / self.base
            return form, form - self.half - atan(along)

        # A small part of the root circle remains, for the arc between two points.
        low, high, room = 0.0, TIP * module, 0.98 * pi / teeth
        if centre(high)[1] > room:
            for _ in range(60):
                middle = (low + high) / 2
                if centre(middle)[1] > room:
                    high = middle
                else:
                    low = middle
            high = low
        self.corner = high
        self.form, self.angle = centre(high)
        z, _, tip, distance = pinion
        ratio = z / teeth
        working = tan(np.arccos((1 - ratio) * self.base / distance))
        base = ratio * self.base
        self.last = working + (sqrt((tip / 2) ** 2 - base**2) - base * working) / self.base
        self.pinion = pinion
        assert self.last < self.form, "interference"

    def flank(self, roll):
        turn = roll - self.half
        return (
            self.base * (sin(turn) - roll * cos(turn)),
            self.base * (cos(turn) + roll * sin(turn)),
        )

    def fillet(self, part):
        """From the root at 0 to the flank at 1."""
        at_root, at_flank = pi / 2 - self.angle, -(self.form - self.half)
        # Angles of the radius of the arc against the x axis, of the mirrored side for the flank.
        end = pi + at_flank
        way = at_root + part * (end - at_root)
        middle = self.root - self.corner
        return (
            middle * sin(self.angle) + self.corner * cos(way),
            middle * cos(self.angle) + self.corner * sin(way),
        )

    def chords(self, scale):
        fillet, flank = round(16 / scale), round(24 / scale)
        return (
            [self.fillet(i / fillet) for i in range(fillet + 1)],
            [self.form + (self.tip - self.form) * i / flank for i in range(1, flank + 1)],
        )

    def rolls(self):
        margin = 0.4 * MARGIN / self.teeth
        return np.linspace(self.tip + margin, self.last - margin, 5)


def record(teeth, module, outer, shift, tip, pinion, planes=("stress",)):
    ring = Ring(teeth, module, outer, shift, tip, pinion)
    _, rough = compliance(ring, 1, planes, [PATCH])
    rolls, found = compliance(ring, 0.5, planes, [PATCH, PATCH / 2])
    for plane in planes:
        best = found[plane, PATCH]
        change = lambda other: [
            float(f"{max(abs(o / b - 1)) if len(b) else 0:.1e}") for o, b in zip(other, best)
        ]
        print(f"\n[[ring]]\nteeth = {teeth}\nmodule = {module}\nprofile_shift = {shift}")
        print(f"outer = {outer}\ntip_diameter = {tip}")
        z, own_shift, pinion_tip, distance = ring.pinion
        print(f"pinion_teeth = {z}\npinion_profile_shift = {own_shift}\npinion_tip_diameter = {pinion_tip}")
        print(f'centre_distance = {distance}\nplane = "{plane}"')
        print(f"roll = {[round(float(r), 6) for r in rolls]}")
        print(f"own = {[round(float(v), 4) for v in best[0]]}")
        print(f"coupling = {[round(float(v), 4) for v in best[1]]}")
        print(f"mesh_error = {change(rough[plane, PATCH])}")
        print(f"patch_error = {change(found[plane, PATCH / 2])}", flush=True)


if __name__ == "__main__":
    print(HEADER)
    print(f"#\n# gmsh {gmsh.__version__}; elements of {FINE / 2} modules at the teeth, loaded over")
    print(f"# {2 * PATCH} modules along the line of action.", flush=True)
    both = ("stress", "strain")
    record(60, 4e-3, 270e-3, 0.0, 234e-3, (20, 0.0, 88e-3, 80e-3), planes=both)
    record(60, 4e-3, 400e-3, 0.0, 234e-3, (20, 0.0, 88e-3, 80e-3))
    record(93, 4e-3, 440e-3, 0.1171, 363.0632e-3, (36, 0.50, 154.6e-3, 111.2381e-3))
    record(56, 4e-3, 270e-3, -0.5013, 220.0e-3, (17, 0.79, 79.6e-3, 76.7111e-3))

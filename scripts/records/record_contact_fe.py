"""Loaded contact of gears by plane finite elements, for tests of the mesh from its teeth.

    python -m venv fe && fe/bin/pip install gmsh==4.15.* numpy scipy
    fe/bin/python scripts/records/record_contact_fe.py > tests/data/contact-fe.toml

Both gears of a pair are whole, as in record_tooth_fe.py. The wheel is fixed at its bore, the pinion
turned at its bore. Nodes on the flanks of every pair of teeth that may touch face each other. Their
compliance is that of the two whole gears. Their gaps are those of the undeformed flanks, also beyond
the ends of the path of contact, where a tip's corner touches. Both define a linear complementarity
problem without friction. It shares only the drawing with the program.
"""

from math import ceil, cos, pi, sin, sqrt, tan

import gmsh
import numpy as np
from record_tooth_fe import ALPHA, FINE, NU, Gear, held, mesh, turned
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls
from scipy.spatial import cKDTree

YOUNG, WIDTH = 206e9, 20e-3
LOADS = [67e3, 300e3]  # N/m
STEP = 0.02  # of the load, to both sides, for the tangent stiffness
REACH = 50e-6  # gap beyond which a pair of teeth cannot touch under these loads
PLANES = ["stress", "strain"]
HEADER = f"""\
# Made by scripts/records/record_contact_fe.py: both gears of a pair in plane finite elements, in contact
# without friction, on one flank only. Lengths in m, forces in N; rack 1 / 1.25 / 0.38, 20 degrees,
# reference centre distance, sharp tip corners; E {YOUNG / 1e9:.0f} GPa, Poisson's ratio {NU}.
#
# face_width: stiffness and force are for it; plane: of stress or of strain.
# bore: of pinion and wheel, rigid; the wheel's stays, the pinion's turns.
# line_load: the pinion's moment over its base radius and over the face width.
# place: one for each mesh position: where one pair of teeth is in contact, from the pitch point
#   along the line of action, positive towards the pinion's tip. Other pairs are whole base
#   pitches ahead or behind.
# transmission_error: rotation of the pinion's bore under the load times its base radius, from where
#   rigid flanks without gaps on the path of contact would touch.
# secant: force (line_load times face_width) over transmission_error.
# tangent: difference of the force over that of transmission_error between {1 - STEP} and {1 + STEP}
#   of the load.
# shares: of the line load, by pair: [a base pitch behind place, at place, a base pitch ahead].
# *_on_path: where only those pairs can touch that are on the path of contact without load.
# mesh_error: largest relative change of [transmission_error, 1 / tangent] with elements half as
#   long, along the contact too; over the start of the path of contact, the middles of double and of
#   single contact, and of *_on_path."""


def hertz(pinion, wheel, line_load):
    """Half width of contact for equally curved flanks."""
    radius = (pinion.pitch + wheel.pitch) * sin(ALPHA) / 4
    return sqrt(8 * line_load * radius * (1 - NU**2) / (pi * YOUNG))


class Mating:
    """Nodes of one pair of teeth that may touch, at `place` on the line of action: roll angles of
    vertices and of all nodes by gear, turn of the common normal from each flank's own, and gap.

    Each gear has its own frame: axis at 0, the other axis at (distance, 0). The line of action
    touches the base circle at the angle -ALPHA."""

    def __init__(self, gears, place, edge, reach):
        nominal = [tan(ALPHA) + sign * place / g.base for sign, g in zip((1, -1), gears)]
        self.on_path = all(roll <= g.tip * (1 + 1e-9) for roll, g in zip(nominal, gears))
        distance = gears[0].pitch + gears[1].pitch
        # Nodes are on the flank nearer its tip, opposite nodes where their normals meet the other flank.
        one = 1 if place < 0 else 0
        tip, two = gears[one], 1 - one
        count = ceil(reach / edge)
        arcs = edge * np.arange(-count, count + 1)
        centre = min(nominal[one], tip.tip)
        room = (tip.tip**2 - centre**2) * tip.base / 2
        if room < arcs[-1]:  # a vertex at the corner
            arcs += room - edge * ceil(room / edge)
        rolls = np.sqrt(centre**2 + 2 * arcs / tip.base)
        rolls = np.minimum(rolls[rolls <= tip.tip * (1 + 1e-12)], tip.tip)

        def opposite(rolls):
            touch = nominal[one] - ALPHA - rolls
            x = tip.base * (np.cos(touch) - np.sin(touch) * rolls)
            y = tip.base * (np.sin(touch) + np.cos(touch) * rolls)
            away = np.sqrt((distance - x) ** 2 + y**2 - gears[two].base ** 2)
            angle = np.arctan2(-y, distance - x) - np.arctan2(away, gears[two].base)
            facing = nominal[two] - ALPHA - angle
            gap = away - gears[two].base * facing
            return facing, gap, angle - touch

        facing, _, _ = opposite(rolls)
        fits = (facing >= gears[two].form) & (facing <= gears[two].tip)
        rolls, facing = rolls[fits], facing[fits]
        self.vertices = [None, None]
        self.vertices[one], self.vertices[two] = rolls, facing[::-1]
        both = np.sort(np.concatenate([rolls, (rolls[1:] + rolls[:-1]) / 2]))
        # The flank continues at both ends, except at a corner: these nodes may not press.
        self.ends = [0] if rolls[-1] > tip.tip * (1 - 1e-9) else [0, -1]
        across, self.gap, tilt = opposite(both)
        self.rolls, self.tilts = [None, None], [None, None]
        self.rolls[one], self.rolls[two] = both, across
        self.tilts[one], self.tilts[two] = tilt, np.zeros_like(tilt)
        # Arm of the common normal about the pinion's axis, over its base radius.
        self.arm = np.cos(self.tilts[0]) + self.rolls[0] * np.sin(self.tilts[0])


def compliance(gear, index, matings, scale):
    """Compliance of one gear between all nodes along their normals, by plane, times Young's modulus."""
    tooth = lambda ahead: ahead if index else -ahead  # a base pitch ahead, clockwise
    stretches = {tooth(ahead): mating.vertices[index] for ahead, mating in matings}
    nodes, elements = mesh(gear, scale, stretches)
    places, normals = [], []
    for ahead, mating in matings:
        turn = 2 * pi * tooth(ahead) / gear.teeth
        for roll, tilt in zip(mating.rolls[index], mating.tilts[index]):
            x, y = gear.flank(roll)
            slope = roll - gear.half
            places.append(turned((-x, y), turn))
            normals.append(turned((cos(slope), -sin(slope)), turn - tilt))
    away, at = cKDTree(nodes).query(places)
    assert max(away) < 1e-3 * gear.module * FINE, max(away)
    assert len(set(at)) == len(at)
    loads = np.zeros((2 * len(nodes), len(at)))
    for column, (node, normal) in enumerate(zip(at, normals)):
        loads[2 * node : 2 * node + 2, column] = normal
    found = {}
    for plane in PLANES:
        free, solver = held(gear, nodes, elements, plane)
        matrix = loads[free].T @ solver.solve(loads[free])
        found[plane] = (matrix + matrix.T) / 2
    return found


def balance(matrix, gap, arm, line_load):
    """Approach and forces: matrix @ forces + gap - arm * approach >= 0, forces >= 0, one of them
    0 at every node, and arm @ forces the line load."""
    root = cholesky(matrix, lower=True)
    approach, last = min(gap) + 1e-5, None
    for _ in range(100):
        forces, _ = nnls(root.T, solve_triangular(root, arm * approach - gap, lower=True))
        active = forces > 0
        if last is not None and np.array_equal(active, last):
            return approach, forces
        last = active
        inner = matrix[np.ix_(active, active)]
        rigid, open_ = np.linalg.solve(inner, np.stack([arm[active], gap[active]], 1)).T
        approach = (line_load + arm[active] @ open_) / (arm[active] @ rigid)
    raise RuntimeError("no balance")


def matings_at(gears, place, scale):
    pinion, wheel = gears
    base_pitch = 2 * pi * pinion.base / pinion.teeth
    edge = scale * hertz(*gears, LOADS[0]) / 4
    reach = 1.25 * hertz(*gears, LOADS[-1])
    found = []
    for ahead in (-1, 0, 1):
        mating = Mating(gears, place + ahead * base_pitch, edge, reach)
        if len(mating.gap) and min(mating.gap) < REACH:
            found.append((ahead, mating))
    return found


def solve(gears, place, scale):
    """Approach, tangent compliance and shares, by plane and line load, of all pairs that may touch
    and of only those on the path of contact."""
    matings = matings_at(gears, place, scale)
    parts = [compliance(gear, index, matings, scale) for index, gear in enumerate(gears)]
    gap, arm = (np.concatenate([getattr(m, key) for _, m in matings]) for key in ("gap", "arm"))
    owner = np.concatenate([np.full(len(m.gap), ahead) for ahead, m in matings])
    on_path = np.isin(owner, [ahead for ahead, mating in matings if mating.on_path])
    found = {}
    for plane in PLANES:
        matrix = (parts[0][plane] + parts[1][plane]) / YOUNG
        for load in LOADS:
            results = []
            for part in (np.ones_like(on_path), on_path):
                arguments = matrix[np.ix_(part, part)], gap[part], arm[part]
                approach, forces = balance(*arguments, load)
                for ahead, mating in matings:
                    own = forces[owner[part] == ahead]
                    assert not own.size or not own[mating.ends].any(), "too short a stretch"
                more, less = (balance(*arguments, load * (1 + s * STEP))[0] for s in (1, -1))
                borne = arm[part] * forces / load
                shares = [borne[owner[part] == ahead].sum() for ahead in (-1, 0, 1)]
                results.append((approach, (more - less) / (2 * STEP * load), shares))
            found[plane, load] = results
    return found


def places(gears):
    """Places of the pair that came into contact last, over a mesh cycle."""
    start, end = (sign * g.base * (g.tip - tan(ALPHA)) for sign, g in zip((-1, 1), gears[::-1]))
    base_pitch = 2 * pi * gears[0].base / gears[0].teeth
    double = (end - start) / base_pitch - 1
    single = 1 - double
    phases = [0, 0.03, double / 4, double / 2, 0.75 * double, double - 0.03]
    phases += [double + part for part in (0.03, single / 4, single / 2, 0.75 * single)] + [0.97]
    phases = sorted([*phases, *([-start / base_pitch] if gears[0].teeth != gears[1].teeth else [])])
    checked = [start, start + double / 2 * base_pitch, start + (double + single / 2) * base_pitch]
    return [start + phase * base_pitch for phase in phases], checked


def record(teeth, module, bores):
    gears = [Gear(z, module, bore) for z, bore in zip(teeth, bores)]
    everywhere, checked = places(gears)
    cases = [solve(gears, place, 1.0) for place in everywhere]
    finer = {place: solve(gears, place, 0.5) for place in checked}
    for plane in PLANES:
        for load in LOADS:
            results = [case[plane, load] for case in cases]
            text = lambda values: "[" + ", ".join(f"{v:.5g}" for v in values) + "]"
            print(f"\n[[contact]]\nteeth = {teeth}\nmodule = {module}\nbore = {bores}")
            print(f'face_width = {WIDTH}\nplane = "{plane}"\nline_load = {load}')
            print(f"place = {text(everywhere)}")
            for part, suffix in enumerate(("", "_on_path")):
                approach, softness, shares = zip(*(r[part] for r in results))
                print(f"transmission_error{suffix} = {text(approach)}")
                print(f"secant{suffix} = {text(load * WIDTH / np.array(approach))}")
                print(f"tangent{suffix} = {text(WIDTH / np.array(softness))}")
                rows = ", ".join("[" + ", ".join(f"{v:.4f}" for v in row) + "]" for row in shares)
                print(f"shares{suffix} = [{rows}]")
            errors = [0.0, 0.0]
            for place, case in finer.items():
                nearest = min(range(len(cases)), key=lambda i: abs(everywhere[i] - place))
                for fine, rough in zip(case[plane, load], results[nearest]):
                    errors = [max(e, abs(f / r - 1)) for e, f, r in zip(errors, fine, rough)]
            print(f"mesh_error = {text(errors)}", flush=True)


if __name__ == "__main__":
    print(HEADER)
    print(f"#\n# gmsh {gmsh.__version__}; elements of {FINE} modules at the teeth, along the contact")
    print("# a quarter of the half width of contact at the lower load.")
    record([62, 62], 2e-3, [35e-3, 35e-3])
    record([20, 30], 4e-3, [48e-3, 76e-3])

"""Compliance of gears by plane finite elements, for tests/gears/gear_finite_elements.rs.

    python -m venv fe && fe/bin/pip install gmsh==4.15.* numpy scipy
    fe/bin/python scripts/records/record_tooth_fe.py > tests/data/tooth-fe.toml

A whole gear, with teeth cut by the basic rack, in quadratic triangles of plane stress or plane
strain, is fixed at its bore. A unit force per unit width acts on a short stretch of flank of one
tooth. The result is the displacement along the force where it crosses the centre line of a tooth: of
the same tooth, and of a neighbour loaded a base pitch ahead. Everything is times Young's modulus. It
shares only the drawing with the program.
"""

from math import ceil, cos, pi, radians, sin, sqrt, tan

import gmsh
import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

ALPHA, ADDENDUM, DEDENDUM, TIP, NU = radians(20), 1.0, 1.25, 0.38, 0.3
FINE, COARSE = 0.12, 1.5  # edges of elements near loaded teeth and far from them, in modules
PATCH = 0.1  # half of the loaded stretch, along the line of action, in modules
MARGIN = 1.2  # of the outer roll angles to the ends of the flank, over the number of teeth
HEADER = """\
# Made by scripts/records/record_tooth_fe.py: whole gears in plane finite elements, held at the bore.
# Lengths in m, angles in rad; rack 1 / 1.25 / 0.38, 20 degrees; Poisson's ratio 0.3. The tip circle
# has the diameter m (z + 2 x + 2): no tip alteration, as beside a mate of opposite profile shift.
#
# plane: of stress or of strain.
# roll: roll angles of the contact on the flank, tan of the pressure angle there.
# own: displacement at the loaded tooth, along the force, of the point where the force's line
#   crosses the tooth's centre line, under a unit force per unit width normal to the flank, the
#   contact's own indentation thus left out; times E.
# coupling: the same displacement at the tooth whose flank is in contact a base pitch further
#   towards its tip (along that tooth's own line of force and on its own centre line), for the first
#   of the roll angles, as many as leave that contact on the flank.
# mesh_error: largest relative change of [own, coupling] from a mesh with elements and chords of the
#   flanks twice as long to the one recorded.
# patch_error: largest relative change of [own, coupling] where the loaded stretch is halved."""


class Gear:
    """Profile of a tooth by the angle of the rack's normal and by roll angle."""

    inner = False  # whether the teeth point towards the axis, and `bore` is the outer diameter

    def __init__(self, teeth, module, bore, shift=0.0):
        self.teeth, self.module, self.bore, self.shift = teeth, module, bore, shift
        self.pitch = module * teeth / 2
        self.base = self.pitch * cos(ALPHA)
        self.half = (pi / 2 + 2 * shift * tan(ALPHA)) / teeth + tan(ALPHA) - ALPHA
        straight = module * (DEDENDUM - TIP * (1 - sin(ALPHA)) - shift)
        self.form = (self.pitch * sin(ALPHA) - straight / sin(ALPHA)) / self.base
        self.tip = sqrt(((self.pitch + (ADDENDUM + shift) * module) / self.base) ** 2 - 1)
        assert self.form > 0, "undercut"

    def fillet(self, normal):
        depth, radius = self.module * (DEDENDUM - TIP - self.shift), self.module * TIP
        land = pi / 4 - (DEDENDUM - TIP) * tan(ALPHA) - TIP / cos(ALPHA)
        turn = (depth / tan(normal) + self.module * (pi / 2 - land)) / self.pitch
        reach = depth / sin(normal) + radius
        return (
            self.pitch * sin(turn) - reach * cos(normal - turn),
            self.pitch * cos(turn) - reach * sin(normal - turn),
        )

    def flank(self, roll):
        turn = roll - self.half
        return (
            self.base * (roll * cos(turn) - sin(turn)),
            self.base * (roll * sin(turn) + cos(turn)),
        )

    def rolls(self):
        """Roll angles of the loads."""
        margin = MARGIN / self.teeth
        return np.linspace(self.form + margin, self.tip - margin, 5)

    def chords(self, scale):
        """Points of the fillet, and roll angles of the flank after its first."""
        fillet, flank = ceil(16 / scale), ceil(24 / scale)
        return (
            [self.fillet(pi / 2 + (ALPHA - pi / 2) * i / fillet) for i in range(fillet + 1)],
            [self.form + (self.tip - self.form) * i / flank for i in range(1, flank + 1)],
        )


def turned(point, angle):
    """Clockwise."""
    x, y = point
    return x * cos(angle) + y * sin(angle), y * cos(angle) - x * sin(angle)


def mesh(gear, scale=1.0, stretches=None):
    """Nodes and six-node triangles, fine in five teeth around the first.

    `stretches` are left flanks, by tooth, with one element edge between neighbouring given roll
    angles."""
    stretches = stretches or {}
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.ElementOrder", 2)
    geo, fine, coarse = gmsh.model.geo, FINE * scale * gear.module, COARSE * scale * gear.module
    centre, outline, first, last, single = geo.addPoint(0, 0, 0), [], None, None, []
    contact, edge, loaded = [], fine, []
    for tooth in range(gear.teeth):
        near = min(tooth, gear.teeth - tooth) <= 2
        fillet, rolls = gear.chords(scale if near else 4)

        def put(point, size=fine if near else coarse):
            return geo.addPoint(*turned(point, 2 * pi * tooth / gear.teeth), 0, size)

        right = [put(p) for p in reversed(fillet + [gear.flank(r) for r in rolls])]
        left = [put((-x, y)) for x, y in fillet]
        stretch = stretches.get(tooth if tooth <= gear.teeth / 2 else tooth - gear.teeth, [])
        if len(stretch):
            edge = gear.base * (stretch[-1] ** 2 - stretch[0] ** 2) / 2 / (len(stretch) - 1)
            gap = 1.5 * (stretch[1] - stretch[0])
            rolls = [r for r in rolls if not stretch[0] - gap < r < stretch[-1] + gap]
        for roll in sorted([*rolls, *stretch], reverse=gear.inner):
            x, y = gear.flank(roll)
            inside = len(stretch) and stretch[0] <= roll <= stretch[-1]
            left.append(put((-x, y), edge if inside else fine if near else coarse))
            if inside:
                contact.append(left[-1])
        if last is None:
            first = left[0]
        else:
            outline.append(geo.addCircleArc(last, centre, left[0]))
        for p, q in [*zip(left, left[1:]), (left[-1], right[0]), *zip(right, right[1:])]:
            top = q == right[0]
            outline.append(geo.addCircleArc(p, centre, q) if top else geo.addLine(p, q))
            if p in contact and q in contact:
                single.append(outline[-1])
        last = right[-1]
        loaded += left + right if near else []
    outline.append(geo.addCircleArc(last, centre, first))
    quarter = [turned((0, gear.bore / 2), i * pi / 2) for i in range(4)]
    bore = [geo.addPoint(*p, 0, min(coarse, scale * gear.bore / 8)) for p in quarter]
    hole = [geo.addCircleArc(bore[i], centre, bore[(i + 1) % 4]) for i in range(4)]
    loops = [geo.addCurveLoop(outline), geo.addCurveLoop(hole)]
    geo.addPlaneSurface(loops[::-1] if gear.inner else loops)
    for line in single:
        geo.mesh.setTransfiniteCurve(line, 2)
    geo.synchronize()
    field, near = gmsh.model.mesh.field, 0.5 * gear.module
    stages = [(loaded, fine, near, coarse, 14 * gear.module)]
    if contact:
        stages.append((contact, edge, 2 * edge, coarse, 5 * coarse))
    growths = []
    for points, *limits in stages:
        distance = field.add("Distance")
        field.setNumbers(distance, "PointsList", points)
        growths.append(field.add("Threshold"))
        field.setNumber(growths[-1], "InField", distance)
        for key, value in zip(("SizeMin", "DistMin", "SizeMax", "DistMax"), limits):
            field.setNumber(growths[-1], key, value)
    finest = field.add("Min")
    field.setNumbers(finest, "FieldsList", growths)
    field.setAsBackgroundMesh(finest)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.model.mesh.generate(2)
    tags, places, _ = gmsh.model.mesh.getNodes()
    kinds, _, members = gmsh.model.mesh.getElements(2)
    (nodes,) = [m for kind, m in zip(kinds, members) if kind == 9]
    gmsh.finalize()
    row = np.zeros(int(max(tags)) + 1, int)
    row[tags.astype(int)] = np.arange(len(tags))
    elements = row[nodes.astype(int)].reshape(-1, 6)
    used, elements = np.unique(elements, return_inverse=True)
    return np.array(places).reshape(-1, 3)[used, :2], elements.reshape(-1, 6)


def stiffness(nodes, elements, plane):
    """Stiffness matrix for unit width and unit Young's modulus."""
    normal, across = (1, NU) if plane == "stress" else (1 - NU, NU)
    scale = 1 / (1 - NU**2) if plane == "stress" else 1 / (1 + NU) / (1 - 2 * NU)
    shear = (normal - across) / 2
    law = scale * np.array([[normal, across, 0], [across, normal, 0], [0, 0, shear]])
    blocks = np.zeros((len(elements), 12, 12))
    for a, b in [(1 / 6, 1 / 6), (2 / 3, 1 / 6), (1 / 6, 2 / 3)]:
        c = 1 - a - b
        by = np.array([
            [1 - 4 * c, 4 * a - 1, 0, 4 * (c - a), 4 * b, -4 * b],
            [1 - 4 * c, 0, 4 * b - 1, -4 * a, 4 * a, 4 * (c - b)],
        ])
        jacobian = np.einsum("ij,njk->nik", by, nodes[elements])
        slope = np.einsum("nij,jk->nik", np.linalg.inv(jacobian), by)
        strain = np.zeros((len(elements), 3, 12))
        strain[:, 0, 0::2] = strain[:, 2, 1::2] = slope[:, 0]
        strain[:, 1, 1::2] = strain[:, 2, 0::2] = slope[:, 1]
        weight = np.abs(np.linalg.det(jacobian)) / 6
        weighted = np.einsum("jk,nkl,n->njl", law, strain, weight)
        blocks += np.einsum("nji,njl->nil", strain, weighted)
    freedoms = np.stack([2 * elements, 2 * elements + 1], 2).reshape(-1, 12)
    rows, columns = np.repeat(freedoms, 12, 1).ravel(), np.tile(freedoms, (1, 12)).ravel()
    return sparse.csc_matrix((blocks.ravel(), (rows, columns)), shape=(2 * len(nodes),) * 2)


def held(gear, nodes, elements, plane):
    """The free degrees of freedom, and the factors of their stiffness."""
    radius = np.hypot(*nodes.T) / (gear.bore / 2)
    free = np.repeat(radius < 1 - 1e-6 if gear.inner else radius > 1 + 1e-6, 2)
    matrix = stiffness(nodes, elements, plane)[free][:, free]
    options = {"SymmetricMode": True}
    return free, splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0, options=options)


def interpolation(nodes, elements, point):
    """Nodes of the triangle at a point, and their weights."""
    a, b, c = (nodes[elements[:, i]] for i in range(3))
    cross = lambda u, v: u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    area = cross(b - a, c - a)
    second, third = cross(point - a, c - a) / area, cross(b - a, point - a) / area
    first = 1 - second - third
    at = np.argmax(np.minimum(np.minimum(first, second), third))
    c, a, b = first[at], second[at], third[at]
    weights = [c * (2 * c - 1), a * (2 * a - 1), b * (2 * b - 1), 4 * c * a, 4 * a * b, 4 * b * c]
    return elements[at], np.array(weights)


def compliance(gear, scale, planes, patches):
    """Own and coupling at the roll angles, by plane and half length of the loaded stretch."""
    nodes, elements = mesh(gear, scale)
    pitch = 2 * pi / gear.teeth
    rolls = gear.rolls()
    low, high = sorted([gear.form, gear.tip])

    def force(roll, tooth, point):
        """Unit force as on the left flank of a tooth, or its functional at another point."""
        slope = roll - gear.half
        place = np.array(turned(point, tooth * pitch))
        down = -sin(slope) if gear.inner else sin(slope)
        direction = turned((cos(slope), -down), tooth * pitch)
        members, weights = interpolation(nodes, elements, place)
        vector = np.zeros(2 * len(nodes))
        vector[2 * members], vector[2 * members + 1] = (weights * d for d in direction)
        return vector

    def centre(roll, tooth):
        return force(roll, tooth, (0, gear.base / cos(roll - gear.half)))

    found = {}
    for plane in planes:
        free, solver = held(gear, nodes, elements, plane)
        for patch in patches:
            own, coupling = [], []
            for roll in rolls:
                load = np.zeros(2 * len(nodes))
                for part in np.linspace(-1, 1, 5) * patch * gear.module / gear.base:
                    x, y = gear.flank(min(max(roll + part, low), high))
                    load += force(roll, 0, (-x, y)) / 5
                displacement = np.zeros_like(load)
                displacement[free] = solver.solve(load[free])
                own.append(centre(roll, 0) @ displacement)
                # The force pushes clockwise: against the rotation of a driving pinion, with that of
                # a wheel. On both, the next tooth counter-clockwise is in contact nearer its tip. In
                # a ring the next tooth clockwise is in contact nearer its root.
                if roll + pitch <= high:
                    ahead = 1 if gear.inner else -1
                    coupling.append(centre(roll + pitch, ahead) @ displacement)
            found[plane, patch] = np.array(own), np.array(coupling)
    return rolls, found


def record(teeth, module, bore, shift=0.0, planes=("stress",)):
    gear = Gear(teeth, module, bore, shift)
    _, rough = compliance(gear, 1, planes, [PATCH])
    rolls, found = compliance(gear, 0.5, planes, [PATCH, PATCH / 2])
    for plane in planes:
        best = found[plane, PATCH]
        change = lambda other: [float(f"{max(abs(o / b - 1)):.1e}") for o, b in zip(other, best)]
        print(f"\n[[gear]]\nteeth = {teeth}\nmodule = {module}\nprofile_shift = {shift}")
        print(f"bore = {bore}\ntip_diameter = {2 * gear.base * sqrt(1 + gear.tip**2):.9g}")
        print(f'plane = "{plane}"')
        print(f"roll = {[round(float(r), 6) for r in rolls]}")
        print(f"own = {[round(float(v), 4) for v in best[0]]}")
        print(f"coupling = {[round(float(v), 4) for v in best[1]]}")
        print(f"mesh_error = {change(rough[plane, PATCH])}")
        print(f"patch_error = {change(found[plane, PATCH / 2])}", flush=True)


if __name__ == "__main__":
    print(HEADER)
    print(f"#\n# gmsh {gmsh.__version__}; elements of {FINE / 2} modules at the teeth, loaded over")
    print(f"# {2 * PATCH} modules along the line of action.")
    both = ("stress", "strain")
    record(20, 4e-3, 22e-3, planes=both)
    record(20, 4e-3, 48e-3, planes=both)
    record(17, 4e-3, 19.6e-3, 0.1)
    record(23, 4e-3, 56.5e-3)
    record(30, 4e-3, 76e-3)
    record(37, 4e-3, 69e-3)
    record(37, 4e-3, 23e-3)
    record(62, 2e-3, 35e-3, planes=both)

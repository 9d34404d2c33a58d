"""Compliance of gears by plane finite elements, for tests/gear_finite_elements.rs.

    python -m venv fe && fe/bin/pip install gmsh==4.15.* numpy scipy
    fe/bin/python scripts/record_tooth_fe.py > tests/data/tooth-fe.toml

A whole gear, its teeth cut by the basic rack, in quadratic triangles of plane stress, held at its
bore. A unit force per unit width, spread over a short stretch of flank, acts on one tooth; what
gives is the displacement along the force where it crosses the centre line of a tooth: of the same
tooth, and of a neighbour loaded a base pitch ahead or behind. Everything is times Young's modulus.
Shares nothing with the program but the drawing.
"""

from math import cos, pi, radians, sin, sqrt, tan

import gmsh
import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

ALPHA, ADDENDUM, DEDENDUM, TIP, NU = radians(20), 1.0, 1.25, 0.38, 0.3
FINE, COARSE = 0.12, 0.5  # edges of elements near loaded teeth and elsewhere, in modules
PATCH = 0.06  # half of the loaded stretch, in roll angle


class Gear:
    """Profile of a tooth by the angle of the rack's normal and by roll angle."""

    def __init__(self, teeth, module, bore):
        self.teeth, self.module, self.bore = teeth, module, bore
        self.pitch = module * teeth / 2
        self.base = self.pitch * cos(ALPHA)
        self.half = pi / 2 / teeth + tan(ALPHA) - ALPHA
        straight = module * (DEDENDUM - TIP * (1 - sin(ALPHA)))
        self.form = (self.pitch * sin(ALPHA) - straight / sin(ALPHA)) / self.base
        self.tip = sqrt(((self.pitch + ADDENDUM * module) / self.base) ** 2 - 1)

    def fillet(self, normal):
        depth, radius = self.module * (DEDENDUM - TIP), self.module * TIP
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

    def profile(self):
        fillet = [self.fillet(pi / 2 + (ALPHA - pi / 2) * i / 16) for i in range(17)]
        return fillet + [
            self.flank(self.form + (self.tip - self.form) * i / 24) for i in range(1, 25)
        ]


def turned(point, angle):
    """Clockwise."""
    x, y = point
    return x * cos(angle) + y * sin(angle), y * cos(angle) - x * sin(angle)


def mesh(gear):
    """Nodes and six-node triangles; fine in five teeth about the first."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.ElementOrder", 2)
    geo, fine, coarse = gmsh.model.geo, FINE * gear.module, COARSE * gear.module
    centre, outline, first, last = geo.addPoint(0, 0, 0), [], None, None
    for tooth in range(gear.teeth):
        size = fine if min(tooth, gear.teeth - tooth) <= 2 else coarse
        put = lambda p: geo.addPoint(*turned(p, 2 * pi * tooth / gear.teeth), 0, size)
        left = [put((-x, y)) for x, y in gear.profile()]
        right = [put(p) for p in reversed(gear.profile())]
        if last is None:
            first = left[0]
        else:
            outline.append(geo.addCircleArc(last, centre, left[0]))
        outline += [geo.addLine(p, q) for p, q in zip(left, left[1:])]
        outline.append(geo.addCircleArc(left[-1], centre, right[0]))
        outline += [geo.addLine(p, q) for p, q in zip(right, right[1:])]
        last = right[-1]
    outline.append(geo.addCircleArc(last, centre, first))
    quarter = [turned((0, gear.bore / 2), i * pi / 2) for i in range(4)]
    bore = [geo.addPoint(*p, 0, coarse) for p in quarter]
    hole = [geo.addCircleArc(bore[i], centre, bore[(i + 1) % 4]) for i in range(4)]
    geo.addPlaneSurface([geo.addCurveLoop(outline), geo.addCurveLoop(hole)])
    geo.synchronize()
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


def stiffness(nodes, elements):
    law = np.array([[1, NU, 0], [NU, 1, 0], [0, 0, (1 - NU) / 2]]) / (1 - NU**2)
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
        blocks += np.einsum("nji,jk,nkl,n->nil", strain, law, strain, weight)
    freedoms = np.stack([2 * elements, 2 * elements + 1], 2).reshape(-1, 12)
    rows, columns = np.repeat(freedoms, 12, 1).ravel(), np.tile(freedoms, (1, 12)).ravel()
    return sparse.csc_matrix((blocks.ravel(), (rows, columns)), shape=(2 * len(nodes),) * 2)


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


def record(teeth, module, bore):
    gear = Gear(teeth, module, bore)
    nodes, elements = mesh(gear)
    free = np.repeat(np.hypot(*nodes.T) > bore / 2 * (1 + 1e-6), 2)
    solver = splu(stiffness(nodes, elements)[free][:, free])
    pitch = 2 * pi / teeth

    def force(roll, tooth, point):
        """Unit force as on the left flank of a tooth, or its functional at another point."""
        slope = roll - gear.half
        place = np.array(turned(point, tooth * pitch))
        direction = turned((cos(slope), -sin(slope)), tooth * pitch)
        members, weights = interpolation(nodes, elements, place)
        vector = np.zeros(2 * len(nodes))
        vector[2 * members], vector[2 * members + 1] = (weights * d for d in direction)
        return vector

    def gives(roll, tooth, displacement):
        return force(roll, tooth, (0, gear.base / cos(roll - gear.half))) @ displacement

    rolls = np.linspace(gear.form + PATCH, gear.tip - PATCH, 5)
    own, coupling = [], []
    for roll in rolls:
        load = np.zeros(2 * len(nodes))
        for part in np.linspace(-PATCH, PATCH, 5):
            x, y = gear.flank(min(max(roll + part, gear.form), gear.tip))
            load += force(roll, 0, (-x, y)) / 5
        displacement = np.zeros_like(load)
        displacement[free] = solver.solve(load[free])
        own.append(gives(roll, 0, displacement))
        # The force pushes clockwise: against the rotation of a pinion that drives, with that of
        # a wheel. On either the tooth in contact nearer its tip is the next counter-clockwise.
        if roll + pitch <= gear.tip:
            coupling.append(gives(roll + pitch, -1, displacement))
    print(f"\n[[gear]]\nteeth = {teeth}\nmodule = {module}\nbore = {bore}")
    print(f"roll = {[round(float(r), 6) for r in rolls]}")
    print(f"own = {[round(float(v), 4) for v in own]}")
    print(f"coupling = {[round(float(v), 4) for v in coupling]}")


if __name__ == "__main__":
    print("# Made by scripts/record_tooth_fe.py: compliance per unit width times Young's modulus.")
    print(f"# gmsh {gmsh.__version__}, elements of {FINE} modules at the teeth.")
    record(20, 4e-3, 22e-3)
    record(20, 4e-3, 48e-3)

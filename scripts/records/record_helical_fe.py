"""Helical gears of manifests/gearbox.toml in mesh, by finite elements in three dimensions.

    python -m venv fe && fe/bin/pip install gmsh==4.15.* numpy scipy pypardiso
    fe/bin/python scripts/records/record_helical_fe.py > tests/data/helical-fe.toml

Each gear is whole, as in record_tooth_fe.py: its transverse section, cut by the basic rack, in quadratic triangles.
The section turns along the face with the helix. Legendre polynomials along the axis multiply its displacements, which
turn with it. So the coefficients of elasticity do not vary along the axis, and the stiffness is a sum of products of
sections and faces. Both ends of the face are free, the bore is fixed.

Cells divide the lines of contact of all pairs. A line load normal to the flank acts on one cell. The displacements
normal to the flanks at the middle of all cells follow, each at the tooth's centre line in the same transverse section.
The cells' own flattening is that of plane strain. The contact of both gears then is unilateral. The script shares only
the drawing with the program.
"""

import sys
from functools import partial
from math import acos, asin, atan, atan2, ceil, cos, hypot, pi, radians, sin, sqrt, tan

import numpy as np
import pypardiso
import scipy.sparse as sparse
from numpy.polynomial import legendre
from record_face_fe import POINTS
from record_tooth_fe import ADDENDUM, DEDENDUM, NU, PATCH, TIP, Gear, interpolation, mesh, turned
from scipy.optimize import brentq

YOUNG, SOLID = 206e9, (1 - NU**2) / 206e9
TEETH, MODULE, WIDTH, DISTANCE = (29, 42), 2e-3, 17e-3, 75e-3
NORMAL, HELIX, SHIFTS, BORES, THINNING = radians(20), radians(18), (0.166, 0.0098), (32e-3, 36e-3), 82e-6
RELIEF, LENGTH, CROWNING = 20e-6, 1.6e-3, 4e-6
ALPHA, BASE = atan(tan(NORMAL) / cos(HELIX)), asin(sin(HELIX) * cos(NORMAL))
TORQUES, PHASES, CELL = (5.0, 10.0, 95.0, 190.0), 12, 0.85e-3
FINE, COARSE = (2.0, 14), (3.0, 12)  # size of elements as in record_tooth_fe.py, and degree along the face


class Helical(Gear):
    """Transverse section of a gear."""

    def __init__(self, index):
        self.teeth, self.bore, self.shift = TEETH[index], BORES[index], SHIFTS[index]
        self.module, self.cut = MODULE / cos(HELIX), SHIFTS[index] - THINNING / (2 * MODULE * tan(NORMAL))
        self.pitch = self.module * self.teeth / 2
        self.base = self.pitch * cos(ALPHA)
        self.half = (pi / 2 + 2 * self.cut * tan(NORMAL)) / self.teeth + tan(ALPHA) - ALPHA
        straight = MODULE * (DEDENDUM - TIP * (1 - sin(NORMAL)) - self.cut)
        self.form = (self.pitch * sin(ALPHA) - straight / sin(ALPHA)) / self.base
        tight = working(2 * tan(NORMAL) * sum(SHIFTS) / sum(TEETH))
        shortened = (tight / MODULE - sum(TEETH) / 2 / cos(HELIX)) - sum(SHIFTS)
        self.outer = self.pitch + MODULE * (ADDENDUM + self.shift + shortened)
        self.tip = sqrt((self.outer / self.base) ** 2 - 1)
        self.twist = (1, -1)[index] * tan(BASE) / self.base

    def fillet(self, normal):
        """By the angle of the normal of the rack's round corner in the normal section; an ellipse here."""
        land = pi / 4 - (DEDENDUM - TIP) * tan(NORMAL) - TIP / cos(NORMAL)
        x = MODULE * (pi / 2 - land - TIP * cos(normal)) / cos(HELIX)
        y = -MODULE * (DEDENDUM - TIP - self.cut + TIP * sin(normal))
        # The normal of the transverse section crosses the rolling line behind x.
        behind = -y * cos(normal) * cos(HELIX) / sin(normal)
        turn, height = (x + behind) / self.pitch, self.pitch + y
        return height * sin(turn) - behind * cos(turn), height * cos(turn) + behind * sin(turn)

    def chords(self, scale):
        fillet, flank = ceil(16 / scale), ceil(24 / scale)
        return (
            [self.fillet(pi / 2 + (NORMAL - pi / 2) * i / fillet) for i in range(fillet + 1)],
            [self.form + (self.tip - self.form) * i / flank for i in range(1, flank + 1)],
        )


def working(rise):
    """Centre distance at which the involute function exceeds that of the reference circles."""
    base = sum(TEETH) * MODULE / 2 / cos(HELIX) * cos(ALPHA)
    return base / cos(brentq(lambda a: tan(a) - a - tan(ALPHA) + ALPHA - rise, 0.1, 1.0))


GEARS = Helical(0), Helical(1)
WORKING = acos((GEARS[0].base + GEARS[1].base) / DISTANCE)
PITCH = pi * MODULE / cos(HELIX) * cos(ALPHA)
START = GEARS[1].base * (tan(WORKING) - GEARS[1].tip)
END = GEARS[0].base * (GEARS[0].tip - tan(WORKING))


def tip_gap(gear, mate, beyond):
    """Gap along the line of action at a tip edge, `beyond` behind the end of the path."""

    def origin(turn):
        """Where the mate's involute through the edge begins, as an angle about the mate's centre."""
        angle = atan(gear.tip) - WORKING + turn
        x, y = DISTANCE - gear.outer * cos(angle), -gear.outer * sin(angle)
        roll = sqrt((hypot(x, y) / mate.base) ** 2 - 1)
        return atan2(y, x) + roll - atan(roll)

    return beyond - mate.base * (origin(0) - origin(beyond / gear.base))


def reach(gear):
    """How far a tip edge behind the path has a gap below the least that loads here close."""
    return brentq(lambda u: tip_gap(GEARS[gear], GEARS[1 - gear], u) - 40e-6, 1e-5, 0.4 * PITCH)


MARKS = START - reach(1), START, END, END + reach(0)


def line(place):
    """Cells (position on the path, z, width) of a pair at a place at mid-face, tip edges beyond the path included."""
    ends = [min(max((mark - place) / tan(BASE), -WIDTH / 2), WIDTH / 2) for mark in MARKS]
    cells = []
    for low, high in zip(ends, ends[1:]):
        if high - low > 1e-9:
            count = ceil((high - low) / CELL)
            width = (high - low) / count
            cells += [(place + z * tan(BASE), z, width) for z in low + width * (np.arange(count) + 0.5)]
    return cells


def pairs(phase):
    """Cells of all pairs at a mesh phase, by the number of the pair."""
    first = ceil((MARKS[0] - START - WIDTH * tan(BASE) / 2) / PITCH - phase)
    found = [(j, line(START + (phase + j) * PITCH)) for j in range(first, first + 5)]
    return [(j, cells) for j, cells in found if cells]


def section(nodes, elements, twist):
    """Products of strains integrated over the section, [derivative along the face of one][of the other]."""
    lame, shear = NU / ((1 + NU) * (1 - 2 * NU)), 0.5 / (1 + NU)
    law = np.diag([2 * shear] * 3 + [shear] * 3)
    law[:3, :3] += lame
    blocks = np.zeros((2, 2, len(elements), 18, 18))
    for a, b, weight in POINTS:
        c = 1 - a - b
        shape = np.array([c * (2 * c - 1), a * (2 * a - 1), b * (2 * b - 1), 4 * c * a, 4 * a * b, 4 * b * c])
        by = np.array([
            [1 - 4 * c, 4 * a - 1, 0, 4 * (c - a), 4 * b, -4 * b],
            [1 - 4 * c, 0, 4 * b - 1, -4 * a, 4 * a, 4 * (c - b)],
        ])
        jacobian = np.einsum("ij,njk->nik", by, nodes[elements])
        slope = np.einsum("nij,jk->nik", np.linalg.inv(jacobian), by)
        place = np.einsum("j,njk->nk", shape, nodes[elements])
        # At rest in space a point moves through the turning section: d/dz = partial z + steep, and vectors turn.
        steep = twist * (place[:, 1, None] * slope[:, 0] - place[:, 0, None] * slope[:, 1])
        strain = np.zeros((2, len(elements), 6, 18))
        still, along = strain
        still[:, 0, 0::3] = still[:, 3, 1::3] = still[:, 4, 2::3] = slope[:, 0]
        still[:, 1, 1::3] = still[:, 3, 0::3] = still[:, 5, 2::3] = slope[:, 1]
        still[:, 2, 2::3] = still[:, 4, 0::3] = still[:, 5, 1::3] = 0
        still[:, 2, 2::3] = steep
        still[:, 4, 0::3] += steep
        still[:, 5, 1::3] += steep
        still[:, 4, 1::3] = -twist * shape
        still[:, 5, 0::3] = twist * shape
        along[:, 2, 2::3] = along[:, 4, 0::3] = along[:, 5, 1::3] = shape
        area = np.abs(np.linalg.det(jacobian)) * weight / 2
        for i in (0, 1):
            for j in (0, 1):
                blocks[i, j] += np.einsum("nki,kl,nlj,n->nij", strain[i], law, strain[j], area, optimize=True)
    freedoms = (3 * elements[:, :, None] + np.arange(3)).reshape(-1, 18)
    where = np.repeat(freedoms, 18, 1).ravel(), np.tile(freedoms, (1, 18)).ravel()
    shape = (3 * len(nodes),) * 2
    return [[sparse.csr_matrix((block.ravel(), where), shape=shape) for block in row] for row in blocks]


def polynomials(degree, z):
    """Legendre polynomials over the face, by degree."""
    return legendre.legvander(2 * np.asarray(z) / WIDTH, degree)


class Elements:
    """A gear in elements."""

    def __init__(self, index, scale, degree):
        self.gear, self.index, self.degree = GEARS[index], index, degree
        self.nodes, self.elements = mesh(self.gear, scale)
        self.free = np.repeat(np.hypot(*self.nodes.T) > self.gear.bore / 2 * (1 + 1e-6), 3)
        places, weights = legendre.leggauss(degree + 1)
        values = legendre.legvander(places, degree)
        slopes = np.stack([legendre.legval(places, legendre.legder(row)) for row in np.eye(degree + 1)], 1)
        sides = [values * sqrt(WIDTH / 2), slopes * sqrt(2 / WIDTH)]
        parts = section(self.nodes, self.elements, self.gear.twist)
        data, count = 0, degree + 1
        for i in (0, 1):
            for j in (0, 1):
                part = parts[i][j][self.free][:, self.free].tocoo()
                upper = part.row <= part.col
                face = (sides[i] * weights[:, None]).T @ sides[j]
                data = data + part.data[upper][:, None, None] * face
        rows, columns = part.row[upper], part.col[upper]
        size = count * sum(self.free)
        pointer = np.searchsorted(rows, np.arange(sum(self.free) + 1))
        matrix = sparse.bsr_matrix((data, columns, pointer), shape=(size, size))
        self.matrix = sparse.triu(matrix.tocsr(), format="csr")
        self.solver = pypardiso.PyPardisoSolver(mtype=2)
        self.solver.factorize(self.matrix)

    def roll(self, place):
        sign = (1, -1)[self.index]
        roll = tan(WORKING) + sign * place / self.gear.base
        return min(max(roll, self.gear.form), self.gear.tip)

    def row(self, roll, tooth, point, z):
        """Displacement along the force on a flank at a roll angle, at a point of a tooth's section."""
        slope, turn = roll - self.gear.half, 2 * pi * tooth / self.gear.teeth
        members, weights = interpolation(self.nodes, self.elements, np.array(turned(point, turn)))
        axial = self.gear.base * self.gear.twist
        direction = np.array([*turned((cos(slope), -sin(slope)), turn), axial]) * cos(BASE)
        return members, np.outer(weights, direction), polynomials(self.degree, z)

    def load(self, cell):
        """A unit line load on a cell."""
        place, middle, width = cell
        out = np.zeros((len(self.nodes), 3, self.degree + 1))
        parts = (np.arange(6) + 0.5) / 6 - 0.5
        for z in middle + width * parts:
            for patch in np.linspace(-1, 1, 5) * PATCH * MODULE:
                roll = self.roll(self.on_path(place + (z - middle) * tan(BASE)) + patch)
                x, y = self.gear.flank(roll)
                members, weights, along = self.row(roll, 0, (-x, y), z)
                out[members] += weights[:, :, None] * along * width / cos(BASE) / 30
        return out.reshape(3 * len(self.nodes), -1)[self.free].ravel()

    def on_path(self, place):
        return min(max(place, START), END)

    def measure(self, cells, tooth):
        """Displacements at the middle of cells on a tooth, as rows."""
        size = (3 * len(self.nodes), self.degree + 1)
        rows = []
        for place, z, _ in cells:
            roll = self.roll(self.on_path(place))
            members, weights, along = self.row(roll, tooth, (0, self.gear.base / cos(roll - self.gear.half)), z)
            row = sparse.lil_matrix(size)
            row[(3 * members[:, None] + np.arange(3)).ravel()] = weights.reshape(-1, 1) * along
            rows.append(row.tocsr()[self.free].reshape(1, -1))
        return sparse.vstack(rows, format="csr")

    def compliance(self, phase):
        """Displacements at all cells under a unit line load on each, times E."""
        columns = []
        for j, cells in (found := pairs(phase)):
            # A pair ahead on the path is nearer the tip of the pinion, and on the tooth counter-clockwise.
            ahead = lambda k: (j - k, k - j)[self.index]
            rows = sparse.vstack([self.measure(others, ahead(k)) for k, others in found])
            loads = np.stack([self.load(cell) for cell in cells], 1)
            columns.append(rows @ self.solver.solve(self.matrix, loads))
        return np.hstack(columns)


def gaps(cells, modified):
    """Material missing normal to the flanks, and the gaps at tip edges."""
    found = []
    for place, z, _ in cells:
        off = tip_gap(*GEARS, place - END) if place > END else 0.0
        off += tip_gap(*GEARS[::-1], START - place) if place < START else 0.0
        inside = min(max(place, START), END)
        ends = END - inside, inside - START
        taken = sum(RELIEF * max(0.0, 1 - end / LENGTH) for end in ends) + CROWNING * (2 * z / WIDTH) ** 2
        found.append(off * cos(BASE) + modified * taken)
    return np.array(found)


def flattening(cells):
    """Terms (c, s) of the approach w (c - s ln w) normal to the flanks under a line load w in plane strain.

    Weber & Banaschek 1953; Johnson, Contact Mechanics, 1985, eq. 5.58: from the contact to the centre lines."""
    places = np.clip([place for place, *_ in cells], START, END)
    rolls = [tan(WORKING) + sign * places / gear.base for sign, gear in zip((1, -1), GEARS)]
    curved = 1 / sum(cos(BASE) / (gear.base * roll) for gear, roll in zip(GEARS, rolls))
    half = np.sqrt(4 * curved * 2 * SOLID / pi)  # over the root of the load
    depths = [gear.base * (roll - np.tan(roll - gear.half)) * cos(BASE) for gear, roll in zip(GEARS, rolls)]
    terms = sum(np.log(2 * depth / half) - NU / (2 * (1 - NU)) for depth in depths)
    return 2 / pi * SOLID * terms, 2 / pi * SOLID


def touching(compliance, gap, widths, force):
    """Line loads >= 0 and approach along the line of action of cells with a linear law."""
    on = gap < np.inf
    for _ in range(200):
        inverse = np.linalg.inv(compliance[np.ix_(on, on)])
        per, off = inverse.sum(1) * cos(BASE), inverse @ gap[on]
        approach = (force + widths[on] @ off) / (widths[on] @ per)
        load = np.zeros(len(gap))
        load[on] = approach * per - off
        free = approach * cos(BASE) - gap - compliance @ load
        after = np.where(on, load > 0, free > 0)
        if np.array_equal(after, on):
            return load, approach, widths[on] @ per
        on = after
    raise RuntimeError("contact does not settle")


def meet(matrix, found, torque, modified):
    """Approach, secant, tangent, tangent with the flattening of the mean line load, peak, and shares of the pairs."""
    cells = [cell for _, cells in found for cell in cells]
    widths, gap, force = np.array([w for *_, w in cells]), gaps(cells, modified), torque / GEARS[0].base
    body, (constant, slope) = matrix / YOUNG, flattening(cells)
    load, even = np.full(len(cells), force / WIDTH / 2), force / WIDTH / 2
    for _ in range(60):
        # Cells without load have no contact to flatten; any positive load serves there.
        give = constant - slope * np.log(np.maximum(load, 1e-3 * force / WIDTH))
        last, (load, approach, _) = load, touching(body + np.diag(give), gap, widths, force)
        if max(abs(load - last)) < 1e-9 * max(load):
            break
    on = load > 0
    steep = np.linalg.inv((body + np.diag(give - slope))[np.ix_(on, on)])
    tangent = widths[on] @ steep.sum(1) * cos(BASE)
    for _ in range(60):
        give = constant - slope * np.log(even)
        loads, mean_approach, linear = touching(body + np.diag(give), gap, widths, force)
        even = force / widths[loads > 0].sum()
    owner = np.repeat(np.arange(len(found)), [len(cells) for _, cells in found])
    shares = [float((load * widths)[owner == pair].sum() / force) for pair in range(len(found))]
    secant = force / (approach - min(gap) / cos(BASE))
    return np.array([approach, secant, tangent, mean_approach, linear, max(load)]), shares


def mesh_cycle(scale, degree):
    """Compliances of both gears at all cells, by mesh phase, and the largest asymmetry."""
    phases = (np.arange(PHASES) + 0.5) / PHASES
    total, apart = [0] * PHASES, 0.0
    for index in (0, 1):
        elements = Elements(index, scale, degree)
        for i, phase in enumerate(phases):
            matrix = elements.compliance(phase)
            apart = max(apart, abs(matrix - matrix.T).max() / matrix.max())
            # A force and the displacement that it causes elsewhere may change places (Betti).
            total[i] = total[i] + (matrix + matrix.T) / 2
        elements.solver.free_memory(everything=True)
        print(f"gear {index}: {len(elements.nodes)} nodes", file=sys.stderr, flush=True)
    return phases, total, apart

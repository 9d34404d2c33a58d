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
from math import acos, asin, atan, atan2, ceil, cos, hypot, pi, radians, sin, sqrt, tan

import numpy as np
import pypardiso
import scipy.sparse as sparse
from numpy.polynomial import legendre
from record_face_fe import gauss_points
from record_tooth_fe import ADDENDUM, DEDENDUM, NU, PATCH, TIP, Gear, interpolation, mesh, turned
from scipy.optimize import brentq

YOUNG, SOLID = 206e9, (1 - NU**2) / 206e9
TEETH, MODULE, WIDTH, DISTANCE = (29, 42), 2e-3, 17e-3, 75e-3
NORMAL, HELIX, SHIFTS, BORES, THINNING = radians(20), radians(18), (0.166, 0.0098), (32e-3, 36e-3), 82e-6
RELIEF, LENGTH, CROWNING = 20e-6, 1.6e-3, 4e-6
ALPHA, BASE = atan(tan(NORMAL) / cos(HELIX)), asin(sin(HELIX) * cos(NORMAL))
TORQUES, PHASES = (5.0, 10.0, 95.0, 190.0), 12
PLACES = (np.arange(PHASES) + 0.5) / PHASES  # mesh phases
SPLIT = 6  # parts of a cell between which gaps and flattening vary
# Size of elements as in record_tooth_fe.py, degree along the face, length of cells.
FINE, COARSE, COARSEST = (2.0, 14, 0.85e-3), (3.0, 12, 1.2e-3), (4.5, 8, 1.2e-3)
THIN = 48e-3, 74e-3  # bores that leave little of the bodies


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


def line(place, longest):
    """Cells (position on the path, z, width) of a pair at a place at mid-face, tip edges beyond the path included."""
    ends = [min(max((mark - place) / tan(BASE), -WIDTH / 2), WIDTH / 2) for mark in MARKS]
    cells = []
    for low, high in zip(ends, ends[1:]):
        if high - low > 1e-9:
            count = ceil((high - low) / longest)
            width = (high - low) / count
            cells += [(place + z * tan(BASE), z, width) for z in low + width * (np.arange(count) + 0.5)]
    return cells


def pairs(phase, longest):
    """Cells of all pairs at a mesh phase, by the number of the pair."""
    first = ceil((MARKS[0] - START - WIDTH * tan(BASE) / 2) / PITCH - phase)
    found = [(j, line(START + (phase + j) * PITCH, longest)) for j in range(first, first + 5)]
    return [(j, cells) for j, cells in found if cells]


def section(nodes, elements, twist):
    """Products of strains integrated over the section, [derivative along the face of one][of the other]."""
    lame, shear = NU / ((1 + NU) * (1 - 2 * NU)), 0.5 / (1 + NU)
    law = np.diag([2 * shear] * 3 + [shear] * 3)
    law[:3, :3] += lame
    blocks = np.zeros((2, 2, len(elements), 18, 18))
    for shape, slope, area in gauss_points(nodes, elements):
        place = np.einsum("j,njk->nk", shape, nodes[elements])
        # At rest in space a point moves through the turning section: d/dz = partial z + steep, and vectors turn.
        steep = twist * (place[:, 1, None] * slope[:, 0] - place[:, 0, None] * slope[:, 1])
        strain = np.zeros((2, len(elements), 6, 18))
        still, along = strain
        still[:, 0, 0::3] = still[:, 3, 1::3] = still[:, 4, 2::3] = slope[:, 0]
        still[:, 1, 1::3] = still[:, 3, 0::3] = still[:, 5, 2::3] = slope[:, 1]
        still[:, 2, 2::3] = still[:, 4, 0::3] = still[:, 5, 1::3] = steep
        still[:, 4, 1::3] = -twist * shape
        still[:, 5, 0::3] = twist * shape
        along[:, 2, 2::3] = along[:, 4, 0::3] = along[:, 5, 1::3] = shape
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

    def __init__(self, index, scale, degree, thrust=True):
        self.gear, self.index, self.degree, self.thrust = GEARS[index], index, degree, thrust
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

    def roll(self, place, off=0.0):
        """Roll angle at a position along the line of action, beyond the path that at its end; and a length off it."""
        roll = tan(WORKING) + (1, -1)[self.index] * (min(max(place, START), END) + off) / self.gear.base
        return min(max(roll, self.gear.form), self.gear.tip)

    def row(self, roll, tooth, point, z):
        """Displacement along the force on a flank at a roll angle, at a point of a tooth's section."""
        slope, turn = roll - self.gear.half, 2 * pi * tooth / self.gear.teeth
        members, weights = interpolation(self.nodes, self.elements, np.array(turned(point, turn)))
        axial = self.gear.base * self.gear.twist * self.thrust
        direction = np.array([*turned((cos(slope), -sin(slope)), turn), axial]) * cos(BASE)
        return members, np.outer(weights, direction), polynomials(self.degree, z)

    def load(self, cell):
        """A unit line load on a cell."""
        place, middle, width = cell
        out = np.zeros((len(self.nodes), 3, self.degree + 1))
        parts = (np.arange(6) + 0.5) / 6 - 0.5
        for z in middle + width * parts:
            for patch in np.linspace(-1, 1, 5) * PATCH * MODULE:
                roll = self.roll(place + (z - middle) * tan(BASE), patch)
                x, y = self.gear.flank(roll)
                members, weights, along = self.row(roll, 0, (-x, y), z)
                out[members] += weights[:, :, None] * along * width / cos(BASE) / 30
        return out.reshape(3 * len(self.nodes), -1)[self.free].ravel()

    def measure(self, cells, tooth):
        """Displacements at the middle of cells on a tooth, as rows."""
        size = (3 * len(self.nodes), self.degree + 1)
        rows = []
        for place, z, _ in cells:
            roll = self.roll(place)
            members, weights, along = self.row(roll, tooth, (0, self.gear.base / cos(roll - self.gear.half)), z)
            row = sparse.lil_matrix(size)
            row[(3 * members[:, None] + np.arange(3)).ravel()] = weights.reshape(-1, 1) * along
            rows.append(row.tocsr()[self.free].reshape(1, -1))
        return sparse.vstack(rows, format="csr")

    def compliance(self, found):
        """Displacements at all cells of pairs under a unit line load on each, times E."""
        columns = []
        for j, cells in found:
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


def divided(matrix, found):
    """Cells in SPLIT parts, and the displacements of gears there under line loads on them, linear between cells."""
    parts, blocks, owner = [], [], []
    for pair, (_, cells) in enumerate(found):
        shifts = (np.arange(SPLIT) + 0.5) / SPLIT - 0.5
        part_of = lambda place, z, width, u: (place + width * u * tan(BASE), z + width * u, width / SPLIT)
        spread = [part_of(*cell, u) for cell in cells for u in shifts]
        middles, spots = (np.array([z for _, z, _ in of]) for of in (cells, spread))
        at = np.clip(np.searchsorted(middles, spots) - 1, 0, max(len(cells) - 2, 0))
        block = np.zeros((len(spread), len(cells)))
        rows, next_ = np.arange(len(spread)), np.minimum(at + 1, len(cells) - 1)
        part = (spots - middles[at]) / np.where(next_ > at, middles[next_] - middles[at], np.inf)
        np.add.at(block, (rows, at), 1 - part)
        np.add.at(block, (rows, next_), part)
        parts, owner = parts + spread, owner + [pair] * len(spread)
        blocks.append(block)
    between = sparse.block_diag(blocks).toarray()
    forces = matrix / np.array([width for _, cells in found for *_, width in cells])
    widths = np.array([width for *_, width in parts])
    return parts, widths, np.array(owner), between @ forces @ between.T * widths


def meet(matrix, found, torque, modified):
    """The values of KEYS, and the shares of the pairs in the load."""
    cells, widths, owner, body = divided(matrix / YOUNG, found)
    gap, force = gaps(cells, modified), torque / GEARS[0].base
    constant, slope = flattening(cells)
    give = constant - slope * np.log(force / WIDTH)
    load, linear_approach, linear = touching(body + np.diag(give), gap, widths, force)
    for _ in range(60):
        # Cells without load have no contact to flatten; any small load serves there.
        give = constant - slope * np.log(np.maximum(load, 1e-3 * force / WIDTH))
        last, (load, approach, _) = load, touching(body + np.diag(give), gap, widths, force)
        if max(abs(load - last)) < 1e-9 * max(load):
            break
    else:
        raise RuntimeError("flattening does not settle")
    on = load > 0
    steep = np.linalg.inv((body + np.diag(give - slope))[np.ix_(on, on)])
    tangent = widths[on] @ steep.sum(1) * cos(BASE)
    secant = force / (approach - min(gap) / cos(BASE))
    shares = [float((load * widths)[owner == pair].sum() / force) for pair in range(len(found))]
    return [approach, tangent, secant, max(load), linear_approach, linear], shares


def mesh_cycle(scale, degree, longest, thrust=True, every=1):
    """Pairs and compliances of both gears at all cells, by mesh phase, and the largest asymmetry."""
    cycle = [pairs(phase, longest) for phase in PLACES[::every]]
    total, apart = [0] * len(cycle), 0.0
    for index in (0, 1):
        elements = Elements(index, scale, degree, thrust)
        for i, found in enumerate(cycle):
            widths = np.array([width for _, cells in found for *_, width in cells])
            forces = elements.compliance(found) / widths
            apart = max(apart, abs(forces - forces.T).max() / forces.max())
            # A force and the displacement that it causes elsewhere may change places (Betti).
            total[i] = total[i] + (forces + forces.T) / 2 * widths
        elements.solver.free_memory(everything=True)
        print(f"gear {index}: {len(elements.nodes)} nodes", file=sys.stderr, flush=True)
    return list(zip(cycle, total)), apart


CASES = [(torque, True) for torque in TORQUES] + [(TORQUES[1], False), (TORQUES[-1], False)]
KEYS = "transmission_error", "tangent", "secant", "peak", "linear_transmission_error", "linear_stiffness"
HEADER = f"""\
# Made by scripts/records/record_helical_fe.py: the gears of manifests/gearbox.toml in finite elements of three
# dimensions, whole, held at the bore, both ends of the face free. Lengths in m, forces in N; E {YOUNG / 1e9:.0f} GPa,
# Poisson's ratio {NU}. The gears are aligned. Their axes stay where they are.
#
# base_radius, tip_radius, path: of pinion and wheel in the transverse section; start and end of the path of contact
#   from the pitch point along the transverse line of action.
# phase: mesh phases of the columns below; at phase p the pairs stand at start + (p + j) base pitches at mid-face.
# asymmetry: largest difference of a displacement from that with place and force exchanged, relative to the largest
#   displacement. The means of both are used.
#
# torque: on the pinion [N m].
# modified: whether the flanks have tip relief and crowning; false: involutes.
# transmission_error: approach x along the transverse line of action, from flanks that touch without load at mid-face.
# tangent: dF/dx, with F = torque/base radius and x the transmission error; every part of the face flattens by
#   its own load.
# secant: F over x less the approach at first touch.
# peak: largest line load, force normal to the flank per length of the line of contact.
# linear_transmission_error, linear_stiffness: the same as transmission_error and tangent, but with a flattening in
#   proportion to the load: the secant at the line load F over face width, as the program's tables have it.
# share: shares of the pairs in the load by mesh phase, the latest first.
# mesh_error: relative changes from a mesh with edges 1.5 times as long, two degrees less along the face and cells
#   1.4 times as long to the one recorded: of the means over the phases of transmission_error, tangent and secant,
#   of the largest peak, and of the peak-to-peak values of transmission_error and tangent.
#
# body: with the drawn bores, and with bores that leave little of the bodies: mean of the tangent at {TORQUES[1]:.0f} N m with
#   unmodified flanks, on a coarse mesh; and the same without the axial parts of forces and displacements.
"""


def summary(rows):
    """Means of the first three keys, the largest peak, and two peak-to-peak values."""
    return np.array([*rows[:, :3].mean(0), rows[:, 3].max(), np.ptp(rows[:, 0]), np.ptp(rows[:, 1])])


def text(values):
    return [float(f"{v:.6g}") for v in values]


def record():
    (best, apart), (rough, _) = mesh_cycle(*FINE), mesh_cycle(*COARSE)
    print(HEADER)
    print(f"base_radius = {text(g.base for g in GEARS)}\ntip_radius = {text(g.outer for g in GEARS)}")
    print(f"path = {text([START, END])}\nphase = {text(PLACES)}\nasymmetry = {apart:.2g}")
    for torque, modified in CASES:
        of = lambda cycle: [meet(matrix, found, torque, modified) for found, matrix in cycle]
        found = of(best)
        rows, coarse = (np.array([row for row, _ in cycle]) for cycle in (found, of(rough)))
        print(f"\n[[case]]\ntorque = {torque}\nmodified = {str(modified).lower()}")
        for key, column in zip(KEYS, rows.T):
            print(f"{key} = {text(column)}")
        print(f"share = {[[round(s, 4) for s in shares] for _, shares in found]}")
        print(f"mesh_error = {[float(f'{v:.2g}') for v in summary(coarse) / summary(rows) - 1]}")


def bodies():
    """Mean stiffness of unmodified flanks with the drawn and with thin bodies, with the axial part of forces or not."""
    for bores in (BORES, THIN):
        for gear, bore in zip(GEARS, bores):
            gear.bore = bore
        found = []
        for thrust in (True, False):
            cycle, _ = mesh_cycle(*COARSEST, thrust, 2)
            found.append(np.mean([meet(matrix, pair, TORQUES[1], False)[0][1] for pair, matrix in cycle]))
        print(f"\n[[body]]\nbore = {list(bores)}\nstiffness = {text(found)}", flush=True)


if __name__ == "__main__":
    record()
    bodies()

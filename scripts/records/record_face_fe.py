"""Compliance of gears whose load varies along the face, by finite elements in three dimensions.

    python -m venv fe && fe/bin/pip install gmsh==4.15.* numpy scipy pypardiso
    fe/bin/python scripts/records/record_face_fe.py > tests/data/face-fe.toml

The gear is whole, as in record_tooth_fe.py. Its quadratic triangles are extruded along the face with Legendre
polynomials of high degree. The model is three-dimensional, with both ends of the face free and the bore fixed.
Line loads on a flank vary along the face as cos(n pi (z/b + 1/2)), n = 0, 1, 2 ...; their sums give any load.
The result is the same wave of the displacement along the force, where it crosses the centre line of a tooth: of
the same tooth, and of its neighbour. Everything is times Young's modulus. A wedge of contact of two such gears
follows from these waves and a local flattening. It shares only the drawing with the program.
"""

from math import cos, pi, sin, tan

import numpy as np
import pypardiso
import scipy.sparse as sparse
from numpy.polynomial import legendre
from record_tooth_fe import ALPHA, NU, Gear, interpolation, mesh, turned

WAVES = 10
YOUNG = 206e9
MISALIGNMENTS = (5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3)
# Module, teeth, bores and face width of a pair; size of its elements and degree along the face.
PAIRS = (
    (4e-3, (20, 30), (48e-3, 76e-3), 20e-3, 3.0, 20),
    (4e-3, (20, 30), (48e-3, 76e-3), 10e-3, 4.5, 14),
    (4e-3, (20, 30), (48e-3, 76e-3), 40e-3, 4.5, 14),
    (2.5e-3, (40, 48), (40e-3, 60e-3), 20e-3, 4.5, 14),
    (4e-3, (20, 30), (22e-3, 26e-3), 20e-3, 4.5, 14),
)
PLACES = (0.35, 0.7)  # of the way from the start of the involute to the tip, in roll angle
HEADER = f"""\
# Made by scripts/records/record_face_fe.py: whole gears in finite elements of three dimensions, held at the bore,
# both ends of the face free. Lengths in m, angles in rad; rack 1 / 1.25 / 0.38, 20 degrees; Poisson's
# ratio {NU}; no tip alteration.
#
# own: for each roll angle, by the number n of half waves along the face, the wave n of the displacement at
#   the loaded tooth, along the force, of the point where the force's line crosses the tooth's centre line,
#   under a line load of unit amplitude in the same wave; times E.
# coupling: the same displacement at the next tooth, loaded at the second of the roll angles, under a load at
#   the first.
# across: largest amplitude of another wave that a wave of load makes, relative to the even wave's own.
# error: largest change of own and coupling, relative to that of the even wave, with two degrees less along
#   the face and elements of the section 1.5 times as long.
#
# wedge: a pair of gears, two by two as they stand here, in single contact at the pitch point, E {YOUNG / 1e9:.0f} GPa, flattening by
#   4 (1 - nu^2)/(pi E) times the line load, flanks askew by the misalignment; with all waves of the above.
# contact: load centroid from mid-face, loaded length, approach at mid-face."""

POINTS = [
    (0.445948490915965, 0.445948490915965, 0.223381589678011),
    (0.445948490915965, 0.108103018168070, 0.223381589678011),
    (0.108103018168070, 0.445948490915965, 0.223381589678011),
    (0.091576213509771, 0.091576213509771, 0.109951743655322),
    (0.091576213509771, 0.816847572980459, 0.109951743655322),
    (0.816847572980459, 0.091576213509771, 0.109951743655322),
]


def gauss_points(nodes, elements):
    """Values and slopes by x, y of the shape functions at each Gauss point of all elements, with its area."""
    for a, b, weight in POINTS:
        c = 1 - a - b
        shape = np.array([c * (2 * c - 1), a * (2 * a - 1), b * (2 * b - 1), 4 * c * a, 4 * a * b, 4 * b * c])
        by = np.array([
            [1 - 4 * c, 4 * a - 1, 0, 4 * (c - a), 4 * b, -4 * b],
            [1 - 4 * c, 0, 4 * b - 1, -4 * a, 4 * a, 4 * (c - b)],
        ])
        jacobian = np.einsum("ij,njk->nik", by, nodes[elements])
        slope = np.einsum("nij,jk->nik", np.linalg.inv(jacobian), by)
        yield shape, slope, np.abs(np.linalg.det(jacobian)) * weight / 2


def section(nodes, elements):
    """Integrals over the section of products of the shape functions and their derivatives by x, y."""
    sums = {}
    for shape, slope, area in gauss_points(nodes, elements):
        of = {"": np.broadcast_to(shape, slope[:, 0].shape), "x": slope[:, 0], "y": slope[:, 1]}
        for one, other in (("", ""), ("", "x"), ("", "y"), ("x", "x"), ("x", "y"), ("y", "y")):
            product = np.einsum("n,ni,nj->nij", area, of[one], of[other])
            sums[one, other] = sums.get((one, other), 0) + product
    rows, columns = np.repeat(elements, 6, 1).ravel(), np.tile(elements, (1, 6)).ravel()
    shape = (len(nodes),) * 2
    found = {key: sparse.csr_matrix((v.ravel(), (rows, columns)), shape=shape) for key, v in sums.items()}
    found["y", "x"] = found["x", "y"].T
    return found


def along(degree, width):
    """Integrals over the face of Legendre polynomials and their derivatives, and with the waves."""
    nodes, weights = legendre.leggauss(4 * degree)
    values = np.array([legendre.legval(nodes, np.eye(degree + 1)[i]) for i in range(degree + 1)])
    slopes = np.array([legendre.legval(nodes, legendre.legder(np.eye(degree + 1)[i])) for i in range(degree + 1)])
    waves = np.array([np.cos(n * pi * (nodes + 1) / 2) for n in range(WAVES)])
    half = width / 2
    return (
        (values * weights) @ values.T * half,
        (values * weights) @ slopes.T,
        (slopes * weights) @ slopes.T / half,
        (values * weights) @ waves.T * half,
    )


def compliance(gear, width, scale, degree):
    """Waves of displacement per wave of load, [same tooth at each place, coupling], times E and per unit width."""
    nodes, elements = mesh(gear, scale)
    plane = section(nodes, elements)
    even, mixed, steep, loads = along(degree, width)
    shear, lame = 0.5 / (1 + NU), NU / ((1 + NU) * (1 - 2 * NU))
    rolls = [*(gear.form + (gear.tip - gear.form) * part for part in PLACES), tan(ALPHA)]

    def line(roll, tooth, point):
        slope = roll - gear.half
        place = np.array(turned(point, 2 * pi * tooth / gear.teeth))
        direction = turned((cos(slope), -sin(slope)), 2 * pi * tooth / gear.teeth)
        members, weights = interpolation(nodes, elements, place)
        out = np.zeros((len(nodes), 2))
        out[members] = np.outer(weights, direction)
        return out

    flank = lambda roll: line(roll, 0, (-gear.flank(roll)[0], gear.flank(roll)[1]))
    centre = lambda roll, tooth: line(roll, tooth, (0, gear.base / cos(roll - gear.half)))
    found = np.zeros((4, WAVES, WAVES))
    free = np.hypot(*nodes.T) > gear.bore / 2 * (1 + 1e-6)
    norm = np.array([width if n == 0 else width / 2 for n in range(WAVES)])
    for odd in (0, 1):
        # Displacements in the section are odd or even about mid-face, those along the face the opposite.
        across, axial = np.arange(odd, degree + 1, 2), np.arange(1 - odd, degree + 1, 2)
        z = lambda matrix, one, other: sparse.csr_matrix(matrix[np.ix_(one, other)])
        own, bent = z(even, across, across), z(steep, across, across)
        product = lambda a, b: plane[a, b][free][:, free]
        kron = lambda a, b: sparse.kron(a, b, format="csr")
        blocks = [[None] * 3 for _ in range(3)]
        for i, a in enumerate("xy"):
            for j, b in enumerate("xy"):
                inner = lame * product(a, b) + shear * product(b, a)
                if a == b:
                    inner = inner + shear * (product("x", "x") + product("y", "y"))
                blocks[i][j] = kron(inner, own)
                if a == b:
                    blocks[i][j] += kron(shear * product("", ""), bent)
            # u_x w_z and u_z w_x
            blocks[i][2] = kron(lame * product("", a).T, z(mixed, across, axial)) + kron(
                shear * product("", a), z(mixed.T, across, axial)
            )
            blocks[2][i] = blocks[i][2].T
        blocks[2][2] = kron((lame + 2 * shear) * product("", ""), z(steep, axial, axial)) + kron(
            shear * (product("x", "x") + product("y", "y")), z(even, axial, axial)
        )
        matrix = sparse.bmat(blocks, format="csr")
        count = sum(free)
        # All freedoms of a node side by side.
        order = np.argsort(np.concatenate([np.repeat(np.arange(count), len(n)) for n in (across, across, axial)]), kind="stable")
        matrix = matrix[order][:, order].tocsr()

        def vectors(line_load):
            parts = [np.kron(line_load[free, i][:, None], loads[across]) for i in (0, 1)]
            return np.concatenate([*parts, np.zeros((count * len(axial), WAVES))])[order]

        solver = pypardiso.PyPardisoSolver(mtype=2)
        upper = sparse.triu(matrix, format="csr")
        moved = solver.solve(upper, np.hstack([vectors(flank(roll)) for roll in rolls]))
        solver.free_memory(everything=True)
        for i, roll in enumerate(rolls):
            found[i] += vectors(centre(roll, 0)).T @ moved[:, WAVES * i : WAVES * (i + 1)] / norm[:, None]
        found[-1] += vectors(centre(rolls[1], -1)).T @ moved[:, :WAVES] / norm[:, None]
    return rolls, found


def contact(matrix, width, line_load, misalignment):
    """Load centroid, loaded length and approach at mid-face of a wedge on a face with compliance by waves."""
    count = 4000
    z = (np.arange(count) + 0.5) / count * width - width / 2
    waves = np.cos(np.arange(WAVES)[:, None] * pi * (z / width + 0.5))
    norm = np.array([width if n == 0 else width / 2 for n in range(WAVES)])
    local, step = 4 * (1 - NU**2) / (pi * YOUNG), width / count
    touching = np.ones(count, bool)
    for _ in range(100):
        # Waves d of displacement: d = C (waves of the load), the load (x - gap - d)/local in contact.
        on = waves[:, touching]
        inner = np.eye(WAVES) + matrix / YOUNG @ (on @ on.T * step / local / norm[:, None])
        gap = misalignment * z[touching]
        rigid, open_ = (
            np.linalg.solve(inner, matrix / YOUNG @ (on @ f * step / local / norm)) for f in (np.ones(len(gap)), gap)
        )
        load = [(f - r @ on) / local for f, r in ((np.ones(len(gap)), rigid), (gap, open_))]
        approach = (line_load * width / step + load[1].sum()) / load[0].sum()
        depth = approach - misalignment * z - (approach * rigid - open_) @ waves
        if np.array_equal(depth > 0, touching):
            break
        touching = depth > 0
    else:
        raise RuntimeError("contact does not settle")
    pressure = np.maximum(depth, 0)
    return [float(f"{v:.5g}") for v in ((pressure @ z) / pressure.sum(), touching.sum() * step, approach)]


def record(teeth, module, bore, width, scale, degree):
    gear = Gear(teeth, module, bore)
    rolls, found = compliance(gear, width, scale, degree)
    _, rough = compliance(gear, width, 1.5 * scale, degree - 2)
    print(f"\n[[gear]]\nteeth = {teeth}\nmodule = {module}\nbore = {bore}\nface_width = {width}")
    print(f"roll = {[round(float(r), 6) for r in rolls]}")
    row = lambda matrix: [round(float(v), 4) for v in matrix.diagonal()]
    print(f"own = {[row(matrix) for matrix in found[:-1]]}")
    print(f"coupling = {row(found[-1])}")
    apart = max(abs(m - np.diag(m.diagonal())).max() / found[0][0, 0] for m in found)
    print(f"across = {apart:.2g}")
    print(f"error = {max(abs((r - f).diagonal()).max() / f[0, 0] for r, f in zip(rough, found)):.1g}", flush=True)
    return found[2]


if __name__ == "__main__":
    print(HEADER)
    for number, (module, teeth, bores, width, scale, degree) in enumerate(PAIRS):
        both = sum(record(z, module, bore, width, scale, degree) for z, bore in zip(teeth, bores))
        line_load = 50 / (module * teeth[0] / 2 * cos(ALPHA)) / width
        for misalignment in MISALIGNMENTS:
            print(f"\n[[wedge]]\npair = {number}\nmisalignment = {misalignment}\nline_load = {line_load:.6g}")
            print(f"contact = {contact(both, width, line_load, misalignment)}", flush=True)

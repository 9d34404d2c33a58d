#!/usr/bin/env python3
"""A gearbox housing of beams, reduced to its bearings by Craig and Bampton's method, as a housing file.

    python examples/housing.py [FILE]

Two walls of bars (60 mm by 12 mm) carry the bearings of two shafts. Bars along the shafts join the walls at the cover and at
the floor. Four feet rest on springs. The file keeps the displacements of the four bearings and the eight lowest modes with
the bearings held. manifests/trains/housing.toml uses it. In place of this script a finite-element program writes the
matrices, and gearatlas.housing reads its files.
"""

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np

from gearatlas.housing import Housing, Node

YOUNG, SHEAR, DENSITY = 170e9, 66e9, 7200.0  # cast iron
WIDTH, THICKNESS = 60e-3, 12e-3
FOOT = 3e8  # N/m, in each direction
MODES = 8
XS, YS, ZS = (-70e-3, 0.0, 87.55e-3, 170e-3), (-90e-3, 0.0, 90e-3), (0.0, 60e-3, 120e-3)


def bar(start: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness of a Bernoulli beam over x, y, z, rx, ry, rz of both ends, its thickness along z or y."""
    length = np.linalg.norm(end - start)
    along = (end - start) / length
    thin = np.array([0.0, 0.0, 1.0]) if abs(along[2]) < 0.5 else np.array([0.0, 1.0, 0.0])
    axes = np.array([along, np.cross(thin, along), thin])
    area, wide, flat = WIDTH * THICKNESS, WIDTH**3 * THICKNESS / 12, WIDTH * THICKNESS**3 / 12
    mass, stiffness = np.zeros((12, 12)), np.zeros((12, 12))
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    both = DENSITY * length / 6 * np.array([[2.0, 1.0], [1.0, 2.0]])
    for freedom, spring, inertia in ((0, YOUNG * area, area), (3, SHEAR * 4 * flat, wide + flat)):
        at = np.ix_([freedom, freedom + 6], [freedom, freedom + 6])
        stiffness[at] += spring / length * pair
        mass[at] += inertia * both
    one = length
    bend = np.array([[12, 6 * one, -12, 6 * one], [6 * one, 4 * one**2, -6 * one, 2 * one**2],
                     [-12, -6 * one, 12, -6 * one], [6 * one, 2 * one**2, -6 * one, 4 * one**2]])  # fmt: skip
    move = np.array([[156, 22 * one, 54, -13 * one], [22 * one, 4 * one**2, 13 * one, -3 * one**2],
                     [54, 13 * one, 156, -22 * one], [-13 * one, -3 * one**2, -22 * one, 4 * one**2]])  # fmt: skip
    for places, signs, moment in (((1, 5, 7, 11), (1, 1, 1, 1), wide), ((2, 4, 8, 10), (1, -1, 1, -1), flat)):
        at, sign = np.ix_(places, places), np.outer(signs, signs)
        stiffness[at] += YOUNG * moment / one**3 * sign * bend
        mass[at] += DENSITY * area * one / 420 * sign * move
    turn = np.kron(np.eye(4), axes)
    return turn.T @ mass @ turn, turn.T @ stiffness @ turn


def frame() -> tuple[np.ndarray, np.ndarray, dict[tuple[float, float, float], int]]:
    """Mass, stiffness, and the first freedom of the node at each place."""
    places: dict[tuple[float, float, float], int] = {}
    walls = [(x, y, z) for z in (ZS[0], ZS[2]) for x in XS for y in YS]
    for place in walls + [(x, y, ZS[1]) for x in XS for y in (YS[0], YS[2])]:
        places[place] = 6 * len(places)
    lines = [[(x, y, z) for x in XS] for y in YS for z in (ZS[0], ZS[2])]
    lines += [[(x, y, z) for y in YS] for x in XS for z in (ZS[0], ZS[2])]
    lines += [[(x, y, z) for z in ZS] for x in XS for y in (YS[0], YS[2])]
    lines += [[(x, y, ZS[1]) for x in XS] for y in (YS[0], YS[2])]
    size = 6 * len(places)
    mass, stiffness = np.zeros((size, size)), np.zeros((size, size))
    for start, end in (ends for line in lines for ends in pairwise(line)):
        at = [places[place] + freedom for place in (start, end) for freedom in range(6)]
        own = bar(np.array(start), np.array(end))
        mass[np.ix_(at, at)] += own[0]
        stiffness[np.ix_(at, at)] += own[1]
    for x in (XS[0], XS[-1]):
        for z in (ZS[0], ZS[2]):
            at = places[x, YS[0], z] + np.arange(3)
            stiffness[at, at] += FOOT
    return mass, stiffness, places


def main() -> None:
    mass, stiffness, places = frame()
    size = len(mass)
    sides, shafts = {"left": ZS[0], "right": ZS[2]}, {"input": XS[1], "output": XS[2]}
    nodes = {f"{side} {shaft}": (x, 0.0, z) for side, z in sides.items() for shaft, x in shafts.items()}
    held = [places[place] + way for place in nodes.values() for way in range(3)]
    free = [freedom for freedom in range(size) if freedom not in held]
    inner = stiffness[np.ix_(free, free)]
    # Static shapes of the bearings, then modes with the bearings held.
    shapes = np.zeros((size, len(held) + MODES))
    shapes[held, range(len(held))] = 1.0
    shapes[free, : len(held)] = -np.linalg.solve(inner, stiffness[np.ix_(free, held)])
    lower = np.linalg.inv(np.linalg.cholesky(mass[np.ix_(free, free)]))
    squared, modes = np.linalg.eigh(lower @ inner @ lower.T)
    shapes[free, len(held) :] = (lower.T @ modes)[:, :MODES]
    points = {
        "cover": shapes[places[XS[1], YS[2], ZS[1]] + 1],
        "wall": shapes[places[XS[-1], YS[1], ZS[0]] + 2],
        "foot": shapes[places[XS[0], YS[0], ZS[0]] + 1],
    }
    housing = Housing(
        M=shapes.T @ mass @ shapes,
        K=shapes.T @ stiffness @ shapes,
        nodes={name: Node(place, ("x", "y", "z")) for name, place in nodes.items()},
        internal=[f"mode {number}" for number in range(1, MODES + 1)],
        points=points,
    )
    file = Path(sys.argv[1] if len(sys.argv) > 1 else "box.housing.toml")
    housing.write(file)
    held_hertz = np.sqrt(squared[:MODES]) / (2 * np.pi)
    print(f"{file}: {len(housing.names)} freedoms, modes with bearings held from {held_hertz[0]:.0f} to {held_hertz[-1]:.0f} Hz")


if __name__ == "__main__":
    main()

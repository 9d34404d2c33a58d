#!/usr/bin/env python3
"""The Lyapunov exponent of chaotic rattle from its unstable periodic orbits, beside that of a run.

    python examples/cycle_expansion.py [LONGEST]

A chaotic set is threaded by unstable periodic orbits p of n_p mesh cycles, whose multipliers above 1 have the product
|L_p|. Nothing escapes from an attractor, so that averages per mesh cycle follow from the zeta function at z = 1 (Artuso,
Aurell & Cvitanovic 1990):

    F(z, b) = prod_p (1 - z^n_p exp(b A_p) / |L_p|),    <a> = (dF/db) / (z dF/dz)    at b = 0,

where A_p is the sum of the quantity over the orbit, here the logarithm of its largest multiplier. As a power series in z,
the order n takes the orbits up to that period. Its error is the change from the order before; F(1) is 0 if all orbits
are there. Trajectories win: they are as good after some hundred mesh cycles, which tells how hard the set is to list.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import gearatlas

MANIFEST = Path(__file__).resolve().parents[1] / "manifests/cycle-expansion.toml"
POINT = {"load": 0.3, "speed": "950 rad/s"}
CLOSED, SAME, NEAR = 1e-9, 1e-6, 0.1  # half gaps: a closed orbit, the same point, near the trajectory


@dataclass(frozen=True)
class Orbit:
    """A prime unstable orbit."""

    points: np.ndarray
    """Its states, one per mesh cycle."""
    multipliers: np.ndarray
    """Eigenvalues of its monodromy matrix, the largest first."""

    @property
    def period(self) -> int:
        return len(self.points)

    @property
    def instability(self) -> float:
        moduli = np.abs(self.multipliers)
        return float(np.prod(moduli[moduli > 1.0]))


def newton(cycle: gearatlas.CycleMap, guesses: np.ndarray, period: int, steps: int = 12) -> np.ndarray:
    """Fixed points of the map over `period` cycles, from many guesses at once; those that do not converge are left out."""
    weighted, states = cycle.weighted_components, guesses.copy()
    for _ in range(steps):
        image = cycle.image(states, period, jacobian=True)
        finite = np.isfinite(image.states).all(axis=1)
        states, residual = states[finite], (states - image.states)[finite][:, weighted]
        matrix = image.jacobian[finite][:, weighted][:, :, weighted] - np.eye(len(weighted))
        # Guesses that have gone astray into free flight have no inverse.
        states[:, weighted] += (np.linalg.pinv(matrix) @ residual[..., np.newaxis])[..., 0]
    residual = np.linalg.norm(cycle.weights * (cycle(states, period) - states), axis=1)
    return states[residual < CLOSED]


def orbits(cycle: gearatlas.CycleMap, longest: int, length: int = 20_000, guesses: int = 2000) -> list[Orbit]:
    """Unstable orbits up to a period that a long trajectory comes near, sought from its closest returns."""
    path = [cycle(cycle.start(), 500)]
    for _ in range(length):
        path.append(cycle(path[-1]))
    path, weights, found = np.array(path), cycle.weights, []
    for period in range(cycle.base_period, longest + 1, cycle.base_period):
        far = np.linalg.norm(weights * (path[period:] - path[:-period]), axis=1)
        for state in newton(cycle, path[np.argsort(far)[:guesses]], period):
            known = [point for orbit in found if period % orbit.period == 0 for point in orbit.points]
            if known and np.linalg.norm(weights * (np.array(known) - state), axis=1).min() < SAME:
                continue
            points = np.array([cycle(state, n) for n in range(period)])
            matrix = cycle.image(state, period, jacobian=True).jacobian[0][np.ix_(cycle.weighted_components, cycle.weighted_components)]
            multipliers = np.linalg.eigvals(matrix)
            orbit = Orbit(points, multipliers[np.argsort(-np.abs(multipliers))])
            away = max(np.linalg.norm(weights * (path - point), axis=1).min() for point in points)
            if orbit.instability > 1.0 and away < NEAR:
                found.append(orbit)
    return found


def expand(found: list[Orbit], longest: int) -> tuple[np.ndarray, np.ndarray]:
    """The average by order, 1 first, and F(1): what is missing."""
    series, slope = np.zeros(longest + 1), np.zeros(longest + 1)
    series[0] = 1.0
    for orbit in found:
        n, weight = orbit.period, 1.0 / orbit.instability
        growth = np.log(np.abs(orbit.multipliers[0]))
        slope[n:] -= weight * (slope[:-n] + growth * series[:-n])
        series[n:] -= weight * series[:-n]
    lengths = np.cumsum(np.arange(longest + 1) * series)[1:]
    return np.cumsum(slope)[1:] / lengths, np.cumsum(series)[1:]


def main() -> None:
    longest = int(sys.argv[1]) if len(sys.argv) > 1 else 6
    manifest = gearatlas.load(MANIFEST, {f"grid.{axis}": value for axis, value in POINT.items()})
    found = orbits(gearatlas.CycleMap(manifest.point(0)), longest)
    averages, missing = expand(found, longest)
    print("period  orbits  exponent [1/cycle]  change     F(1)")
    for n in range(1, longest + 1):
        count = sum(orbit.period == n for orbit in found)
        change = averages[n - 1] - averages[n - 2] if n > 1 else np.nan
        print(f"{n:6}  {count:6}  {averages[n - 1]:18.4f}  {change:+.4f}  {missing[n - 1]:+.4f}")
    points = gearatlas.run(manifest, progress=False).points
    print(f"of a run: {points['lambda_max'][0]:.4f} ± {points['lambda_stderr'][0]:.4f}")


if __name__ == "__main__":
    main()

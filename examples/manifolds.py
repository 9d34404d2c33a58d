#!/usr/bin/env python3
"""Basins of an oscillator against a stop, with the manifolds of the saddle between them.

    python examples/manifolds.py [PICTURE]

`gearatlas.follow` finds the orbits of manifests/oscillators/one-sided-stop.toml over the gap of the stop. At the gap of one
saddle every cell of a plane of states is mapped until it settles. The border of the basins is the
stable manifold of the saddle (black).
"""

import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import gearatlas

MANIFEST = Path(__file__).resolve().parents[1] / "manifests/oscillators/one-sided-stop.toml"
GAP = 0.195
# One stiffness, and orbits over the gap alone.
SET = {
    "grid": {"speed": 2.8, "contact.stop.gap": {"from": 0.1, "to": 0.2, "count": 5}, "contact.stop.stiffness": 30.0},
    "continuation": {"over": "contact.stop.gap", "starts": 6, "longest_period": 2},
}


def saddles() -> list[dict]:
    """Orbits with one multiplier outside the unit circle, over the gap."""
    with tempfile.TemporaryDirectory() as folder:
        branches = gearatlas.follow(MANIFEST, folder, set=SET).branches
    return [row for row in branches if row["unstable"] == 1 and row["multiplier_re"] > 1.2]


def basins(mapped: gearatlas.CycleMap, extent: float, cells: int, cycles: int = 240) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates of a square of states about zero, and the number of the motion that each leads to."""
    side = np.linspace(-extent, extent, cells)
    states = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    ends = mapped(states, cycles)
    # 12 cycles hold whole periods of 1, 2, 3, 4 and 6: their sum does not depend on the phase.
    sums = sum((mapped(ends, cycle) for cycle in range(1, 13)), ends * 0.0)
    _, number = np.unique(np.round(sums, 4), axis=0, return_inverse=True)
    return side, number.reshape(cells, cells)


def main() -> None:
    row = min(saddles(), key=lambda row: abs(row["contact.stop.gap"] - GAP))
    mapped = gearatlas.CycleMap(gearatlas.load(MANIFEST, set=SET).point(0)).at({"contact.stop.gap": row["contact.stop.gap"]})
    state = mapped.from_modal(row["displacement"], row["modal_velocity"])
    side, motions = basins(mapped, 1.0, 300 if len(sys.argv) > 1 else 60)
    print(f"gap {row['contact.stop.gap']:.4f}: a saddle of period {row['period']}, and {motions.max() + 1} motions that attract")

    figure, axes = plt.subplots(figsize=(6, 5.5), layout="constrained")
    axes.pcolormesh(side, side, motions, cmap="Pastel1", shading="nearest", rasterized=True)
    for cycle in range(row["period"]):
        point = mapped(state, cycle)
        for stable, style in [(True, "k-"), (False, "r-")]:
            for branch in gearatlas.manifold(mapped, point, row["period"], stable=stable, length=20.0, step=0.01):
                axes.plot(*branch.T, style, linewidth=0.7)
        axes.plot(*point, "ko", markersize=5)
    axes.set(xlim=side[[0, -1]], ylim=side[[0, -1]], xlabel="displacement [m √kg]", ylabel="velocity [m √kg/s]")
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()

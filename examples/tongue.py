#!/usr/bin/env python3
"""A motion with two frequencies beside the speeds at which it locks.

    python examples/tongue.py [PICTURE]

`gearatlas.torus` and `gearatlas.tori` compute and follow invariant circles of manifests/oscillators/flutter.toml over
the speed of the shaker. `gearatlas.follow` finds the orbits of three cycles to which the motion locks, and the folds
at which they end.
"""

import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import gearatlas

MANIFEST = Path(__file__).resolve().parents[1] / "manifests/oscillators/flutter.toml"
AMPLITUDE = "harmonic_load.shaker.amplitude"
ACCURACY = {"tolerance": 5e-3, "most": 135}


def locked(second: bool) -> gearatlas.Table:
    """Bifurcations of locked orbits over the speed, or curves of them over speed and amplitude if `second`."""
    plane = {f'"grid"."{AMPLITUDE}"': {"from": 0.02, "to": 0.4, "count": 5}, "continuation.second": AMPLITUDE}
    with tempfile.TemporaryDirectory() as folder:
        results = gearatlas.follow(gearatlas.load(MANIFEST, set=plane if second else {}), folder)
        return results.curves if second else results.bifurcations


def main() -> None:
    drawn = len(sys.argv) > 1
    folds = sorted(row["speed"] for row in locked(False) if row["kind"] == "fold" and row["period"] == 3)
    print(f"locked at 1/3 from {folds[0]:.4f} to {folds[1]:.4f} rad/s")
    mapped = gearatlas.CycleMap(gearatlas.load(MANIFEST).point())
    middle, sides = sum(folds) / 2.0, []
    for speed in (2.95, 3.15):
        own = mapped.at(speed=speed)
        sides.append(gearatlas.tori(gearatlas.torus(own, own.start(), **ACCURACY), "speed", middle, **ACCURACY))
        last = sides[-1][-1]
        print(f"{len(sides[-1])} circles from {speed} to {last.map.point['speed']:.4f} rad/s, rotation number {last.rotation:.4f}")
    if not drawn:
        return

    figure, (plane, staircase, states) = plt.subplots(1, 3, figsize=(13, 4.2), layout="constrained")
    curves = locked(True)
    for number in np.unique(curves["curve"]):
        rows = curves[curves["curve"] == number]
        if rows["kind"][0] == "fold" and rows["period"][0] == 3:
            plane.plot(rows["speed"], rows[AMPLITUDE], "k-")
    for side in sides:
        for circle in side[:: len(side) // 3]:
            for end in (0.02, 0.4):
                kept = gearatlas.tori(circle, AMPLITUDE, end, free="speed", step=0.1, **ACCURACY)
                speeds = [own.map.point["speed"] for own in kept]
                plane.plot(speeds, [own.map.point[AMPLITUDE] for own in kept], "C0-", linewidth=1)
    plane.set(xlabel="speed [rad/s]", ylabel="amplitude of the shaker [N]", xlim=(2.94, 3.16))
    for side in sides:
        staircase.plot([own.map.point["speed"] for own in side], [own.rotation for own in side], "C0.-", markersize=4)
    staircase.plot(folds, [1 / 3, 1 / 3], "k-", linewidth=3)
    staircase.set(xlabel="speed [rad/s]", ylabel="rotation number [turns per cycle]")
    for circle, style in [(sides[0][0], "C0-"), (sides[0][-1], "C1-")]:
        curve = circle.circle(np.linspace(0.0, 1.0, 600))
        states.plot(curve[:, 1], curve[:, 3], style, label=f"{circle.map.point['speed']:.3f} rad/s")
    own = mapped.at(speed=middle)
    state = own(own.start(), 3000)
    states.plot(*np.array([own(state, cycle) for cycle in range(3)]).T[[1, 3]], "ko", label=f"locked, {middle:.3f} rad/s")
    states.set(xlabel="displacement of mode 2 [m √kg]", ylabel="velocity of mode 2 [m √kg/s]")
    states.legend(fontsize=8)
    figure.savefig(sys.argv[1], dpi=100)


if __name__ == "__main__":
    main()

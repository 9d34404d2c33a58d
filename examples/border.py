#!/usr/bin/env python3
"""The border of two basins of a drive with two modes, and the saddle that rules it.

    python examples/border.py [PICTURE]

Two motions of period 1 coexist in manifests/basins.toml at 265 rad/s. `gearatlas.border` bisects lines between starts
with different ends, and follows the border to its saddle. The space of states has four dimensions, so that no curve parts
the basins.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import gearatlas

MANIFEST = Path(__file__).resolve().parents[1] / "manifests/basins.toml"
EXTENT = 60e-6


def basins(mapped: gearatlas.CycleMap, cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates of a square of displacements of both modes, and where the motion from there is weak."""
    side = np.linspace(-EXTENT, EXTENT, cells)
    states = np.tile(mapped.start(), (cells * cells, 1))
    states[:, :2] += np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    sizes = np.linalg.norm(mapped.weights * mapped(states, 400), axis=1)
    return side, (sizes < 0.5 * (sizes.min() + sizes.max())).reshape(cells, cells)


def main() -> None:
    mapped = gearatlas.CycleMap(gearatlas.load(MANIFEST).point()).at(speed=265.0)
    drawn = len(sys.argv) > 1
    side, weak = basins(mapped, 140 if drawn else 16)
    print(f"{weak.mean():.1%} of the starts lead to the weak motion")
    inner = mapped.start()
    inner[0] -= 5e-6
    found = []
    for angle in np.linspace(0.0, 2.0 * np.pi, 32 if drawn else 1, endpoint=False):
        outer = mapped.start()
        outer[:2] += EXTENT * np.array([np.cos(angle), np.sin(angle)])
        try:
            found.append(gearatlas.border(mapped, inner, outer))
        except gearatlas.AtlasError:
            continue  # This start leads to the weak motion, too.
    border = found[0]
    outside = int((np.abs(border.multipliers) > 1.0).sum())
    assert outside == 1 and all(np.allclose(own.saddle, border.saddle) for own in found)
    print(f"{len(found)} lines: a saddle of period {border.period} with one multiplier outside the unit circle")
    print(f"it is {border.multipliers[0].real:.6f}")

    figure, (plane, time) = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
    plane.pcolormesh(side * 1e6, side * 1e6, ~weak, cmap="Pastel1", shading="nearest", rasterized=True)
    states = np.array([own.state - mapped.start() for own in found]) * 1e6
    plane.plot(states[:, 0], states[:, 1], "k.", markersize=4, label="on the border")
    plane.plot(*(inner - mapped.start())[:2] * 1e6, "k+", label="common start")
    plane.set(xlabel="displacement of mode 1 [µm √kg]", ylabel="displacement of mode 2 [µm √kg]")
    plane.legend(loc="upper right")
    for share, style, label in [(0.0, "k-", "on the border"), (1e-9, "C0-", "1e-9 outwards"), (-1e-9, "C1-", "1e-9 inwards")]:
        motion = [border.state + share * (border.state - inner)]
        for _ in range(60):
            motion.append(mapped(motion[-1]))
        motion = border.track if share == 0.0 else np.array(motion)
        time.semilogy(np.linalg.norm(mapped.weights * (motion - border.saddle), axis=1), style, label=label)
    time.set(xlabel="mesh cycles", ylabel="distance from the saddle [half gaps]")
    time.legend()
    if drawn:
        figure.savefig(sys.argv[1], dpi=110)


if __name__ == "__main__":
    main()

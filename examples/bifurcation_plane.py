#!/usr/bin/env python3
"""Periods of motion over a plane of two keys, and a bifurcation diagram along a line of it, with xarray.

    python examples/bifurcation_plane.py [PICTURE]

The drive is that of manifests/quickstart.toml with its two lowest modes. `gearatlas.sweep` computes the plane of speed and
half gap on all cores. White motions are chaotic, or have more than eight mesh cycles.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import gearatlas

MANIFEST = Path(__file__).resolve().parents[1] / "manifests/quickstart.toml"
MODEL = {"model.modes": 2, "run.cycles": 4000, "analyses.lyapunov": {"effort": "survey"}, "analyses.poincare": {"samples": 60}}


def plane(half_gaps: int = 24, speeds: int = 24) -> gearatlas.Results:
    """The motion over half gap and speed."""
    axes = {"mesh.half_gap": np.linspace(2e-6, 25e-6, half_gaps), "speed": np.linspace(600.0, 1300.0, speeds)}
    return gearatlas.sweep(MANIFEST, axes, load=0.2, set=MODEL)


def main() -> None:
    results = plane()
    motion, samples = results.to_xarray().squeeze("load"), results.to_xarray("poincare").squeeze("load")
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
    motion["period"].where(motion["period"] <= 8).plot(ax=left, cmap="viridis", levels=np.arange(0.5, 9), extend="neither", cbar_kwargs={"ticks": range(1, 9)})
    line = samples["deflection"].sel({"mesh.half_gap": 10e-6}, method="nearest")
    line.plot.line("k.", x="speed", ax=right, markersize=1, add_legend=False)
    share = float((motion["class"] == "chaotic").mean())
    print(f"{share:.0%} of {motion['class'].size} points are chaotic; periods are {np.unique(motion['period'].values[motion['period'] > 0])}")
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()

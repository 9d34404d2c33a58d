#!/usr/bin/env python3
"""Ten thousand motions of an oscillator against a stop, with the curves of their bifurcations.

    python examples/stop_plane.py [PICTURE]

The plane is that of manifests/oscillators/one-sided-stop.toml: gap and stiffness of the stop. `gearatlas.run` computes the
periods on a grid, and `gearatlas.follow` the curves, from orbits alone. Both take about two minutes on two cores.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import gearatlas

MANIFEST = Path(__file__).resolve().parents[1] / "manifests/oscillators/one-sided-stop.toml"
GAP, STIFFNESS = "contact.stop.gap", "contact.stop.stiffness"
COLOURS = {"fold": "tab:red", "period_doubling": "black", "torus": "tab:green", "graze": "tab:blue"}
LONGEST = 8


def draw(axes: plt.Axes, points: gearatlas.Results, curves: gearatlas.Table) -> None:
    """Colours the periods up to eight, other motions white, and draws the curves of every kind."""
    motion = points.to_xarray().squeeze("speed")
    periods = motion["period"].where(motion["period"] <= LONGEST)
    levels = np.arange(0.5, LONGEST + 1)
    periods.plot(ax=axes, x=GAP, cmap="Pastel1", levels=levels, extend="neither", cbar_kwargs={"ticks": range(1, LONGEST + 1)})
    frame = curves.to_pandas()
    for kind, colour in COLOURS.items():
        of_kind = frame[frame["kind"] == kind]
        for number, (_, curve) in enumerate(of_kind.groupby("curve")):
            axes.plot(curve[GAP], curve[STIFFNESS], color=colour, linewidth=0.5, label="_" if number else kind.replace("_", " "))
    axes.set(yscale="log", xlim=(motion[GAP].min(), motion[GAP].max()), ylim=(motion[STIFFNESS].min(), motion[STIFFNESS].max()))
    axes.legend(loc="upper left", fontsize=7)


def main() -> None:
    counts = {f'grid."{name}".count': 100 for name in (GAP, STIFFNESS)}
    points = gearatlas.run(MANIFEST, set=counts)
    curves = gearatlas.follow(MANIFEST).curves
    print(f"{len(points.points)} points, {len(np.unique(curves['curve']))} curves")
    figure, axes = plt.subplots(figsize=(9, 6), layout="constrained")
    draw(axes, points, curves)
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], dpi=110)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Reads the results of a run in pandas and in polars. Prints λ over load and speed with
units, and draws it.

    .venv/bin/python examples/read_results.py results/flex80 [--plot lambda.png]
"""

import argparse
import json
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import polars as pl
import pyarrow.dataset


def metadata(table: Path, key: str):
    """Metadata of the columns: key is `units`, `descriptions` or `axes`."""
    return json.loads(pyarrow.dataset.dataset(table).schema.metadata[key.encode()])


def label(name: str, units: dict[str, str]) -> str:
    """`speed [rad/s]`; no unit when dimensionless."""
    return name if units[name] in ("", "1") else f"{name} [{units[name]}]"


def lambda_table(points: pd.DataFrame, axes: list[str], units: dict[str, str]) -> pd.DataFrame:
    """λ with the slower axis down and the faster one across; no value for points that were not computed."""
    table = points.pivot(index=axes[0], columns=axes[1], values="lambda_max")
    return table.rename_axis(index=label(axes[0], units), columns=label(axes[1], units))


def mark(point: dict) -> str:
    """The mark of a point that is not chaotic."""
    if point["class"] == "periodic":
        return str(int(point["period"]))
    if point["status"] not in ("ok", "not_converged"):
        return "x"
    return {"steady_contact": "L", "quasi_periodic": "q", "not_converged": "?"}.get(point["class"], ".")


def plot(points: pd.DataFrame, axes: list[str], units: dict[str, str], path: Path) -> None:
    """Colour is λ of points with lasting or transient chaos; a number is the period of other points."""
    down, across = (np.sort(points[axis].unique()) for axis in axes[:2])
    grid = np.full((len(down), len(across)), np.nan)
    figure, frame = plt.subplots(figsize=(8.0, 5.0), layout="constrained")
    for point in points.to_dict("records"):
        row = np.searchsorted(down, point[axes[0]])
        column = np.searchsorted(across, point[axes[1]])
        if point["class"] in ("chaotic", "transient_chaos"):
            grid[row, column] = point["lambda_max"]
        if point["class"] == "transient_chaos":
            frame.text(column, row, "t", ha="center", va="center", color="white")
        elif point["class"] != "chaotic":
            frame.text(column, row, mark(point), ha="center", va="center", color="0.2")
    frame.set_facecolor("0.93")
    top = np.nanmax(grid) if np.isfinite(grid).any() else 1.0
    # The brightness of viridis increases: it is readable with colour blindness and in grey print.
    image = frame.imshow(grid, origin="lower", aspect="auto", cmap="viridis", vmin=0.0, vmax=top)
    figure.colorbar(image, label=f"λ of chaotic points [{units['lambda_max']}]")
    for axis, values, ticks in ((frame.yaxis, down, 16), (frame.xaxis, across, 12)):
        shown = range(0, len(values), -(-len(values) // ticks))
        axis.set_ticks(shown, [f"{values[index]:.4g}" for index in shown])
    frame.set_ylabel(label(axes[0], units))
    frame.set_xlabel(label(axes[1], units))
    frame.set_title(
        "colour: chaotic   t: transient chaos   number: period   L: locked   q: quasi-periodic\n"
        "?: not converged   x: failed   .: not classified",
        fontsize="medium",
    )
    figure.savefig(path, dpi=150)
    plt.close(figure)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, help="folder that `atlas run` wrote")
    parser.add_argument("--plot", type=Path, default=Path("lambda.png"), help="picture to write")
    arguments = parser.parse_args()
    table = arguments.results / "points.parquet"
    if not table.exists():
        parser.error(f"no results in {arguments.results}: {table} does not exist")

    units, axes = metadata(table, "units"), metadata(table, "axes")
    points = pd.read_parquet(table)
    print(f"pandas: {len(points)} points; λ [{units['lambda_max']}]")
    if len(axes) >= 2:
        # Further axes are held at their first value.
        for axis in axes[2:]:
            points = points[points[axis] == points[axis].min()]
        print(lambda_table(points, axes, units).round(3).to_string(na_rep="-"))
        plot(points, axes, units, arguments.plot)
        print(f"picture: {arguments.plot}")
    else:
        print(points[[*axes, "class", "lambda_max", "lambda_stderr"]].to_string(index=False))

    frame = pl.read_parquet(table)
    print(f"\npolars: points and largest λ [{units['lambda_max']}] by class")
    print(frame.group_by("class").agg(pl.len(), pl.col("lambda_max").max()).sort("class"))


if __name__ == "__main__":
    main()

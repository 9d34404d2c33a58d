"""The picture and the table of docs/estimators.md.

    .venv/bin/python docs/pictures/estimators.py results/flex80 results/unsettled
"""

import pathlib
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
import polars as pl

HERE = pathlib.Path(__file__).parent


def read(folder):
    return pl.read_parquet(f"{folder}/points.parquet").sort("load", "speed")


def main(settled, unsettled):
    a, b = read(settled), read(unsettled)
    speeds = sorted(a["speed"].unique())
    loads = sorted(a["load"].unique())
    width = 0.6 * (speeds[1] - speeds[0])

    figure, axes = plt.subplots(figsize=(9, 5), constrained_layout=True)
    place = {load: width * (i / (len(loads) - 1) - 0.5) for i, load in enumerate(loads)}
    for table, colour, marker, label in [
        (b, "#d55e00", "x", "unsettled: raw norm, nothing discarded, 320 cycles"),
        (a, "#0072b2", "o", "settled: flex80"),
    ]:
        x = [s + place[l] for s, l in zip(table["speed"], table["load"])]
        axes.errorbar(
            x, table["lambda_max"], yerr=table["lambda_stderr"], fmt=marker, color=colour,
            markersize=4, linewidth=1, capsize=0, label=label,
        )
    axes.axhline(0, color="black", linewidth=0.8)
    axes.set_yscale("symlog", linthresh=0.02)
    axes.set_yticks([-0.02, -0.01, 0, 0.01, 0.02, 0.1, 1])
    axes.set_yticklabels(["-0.02", "-0.01", "0", "0.01", "0.02", "0.1", "1"])
    axes.set_xticks(speeds)
    axes.set_xlabel("speed [rad/s]; within a group the load grows from 5 % to 30 %")
    axes.set_ylabel("largest Lyapunov exponent λ [1/cycle]")
    # Above the axes: bars reach everywhere inside.
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncols=2, frameon=False)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    figure.savefig(HERE / "estimators.png", dpi=110)

    print("| speed [rad/s] | λ settled | class | λ unsettled | reported class |")
    print("|---|---|---|---|---|")
    for speed in speeds:
        row = [f"{speed:.0f}"]
        for table in (a, b):
            part = table.filter(pl.col("speed") == speed)
            low, high = part["lambda_max"].min(), part["lambda_max"].max()
            row.append(f"{low:.4f} … {high:.4f}")
            counts = part.group_by("class", "period").len().sort("len", descending=True)
            row.append(", ".join(
                f"{n} of period {p}" if p else f"{n} {c.replace('_', ' ')}"
                for c, p, n in counts.iter_rows()
            ))
        print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    main(*sys.argv[1:])

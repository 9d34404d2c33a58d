"""Writes summary.md with the speed-up of trajectories as columns of one product.

    python3 scripts/records/record_columns.py COLUMNS.json benches/runs/NAME
"""

import json
import pathlib
import sys

from records import keep, processor, table

MODES = {81: 40, 321: 160, 1281: 640}


def gains(times, columns):
    """Median speed-up of each number of columns over the same number of single ones."""
    single = times[0][0]
    return [f"{count * single / time[0]:.2f}" for count, time in zip(columns[1:], times[1:])]


def main(found, out):
    raw = json.loads(pathlib.Path(found).read_text())
    columns = raw["columns"]
    counts = [f"{count} columns" for count in columns[1:]]
    dense = [
        (MODES[row["dimension"]], row["set"], f"{row['product_ns'][0][0]:.0f}", *gains(row["product_ns"], columns))
        for row in raw["dense"]
    ]
    cycles, shared = [], []
    for row in raw["structured"]:
        scenes = [("constant contact", row)] + [(f"rattle, {scene['load']:.0%}", scene) for scene in row["rattle"]]
        for name, scene in scenes:
            cycles.append((row["modes"], name, f"{scene['cycle_ns'][0][0]:.0f}", *gains(scene["cycle_ns"], columns)))
            if "events" in scene:
                shared.append((row["modes"], name, f"{scene['windows']:.1f}", f"{scene['cut']:.1f}", f"{scene['events']:.2f}"))
    plane = raw["plane"]
    cut = sorted(point[3] / point[2] for point in plane)
    text = [
        "# What trajectories of one speed would gain as columns of one product\n",
        f"{processor()}, {raw['instructions']}, `scripts/record columns`. Medians of rounds in turn, one thread. A gain is the time of "
        "as many single products or cycles over that of one with so many columns.",
        "\n## Products of a dense operator\n",
        "Operators of the table kernels; those of a set take turns.\n",
        *table(("modes", "set", "one product [ns]", *counts), dense),
        "\n## Cycles of the structured kernel\n",
        "The trajectory and tangents beside it, which share its windows, contact and events: a bound of what independent "
        "trajectories could gain, whose events part them.\n",
        *table(("modes", "scene", "one trajectory [ns]", *counts), cycles),
        "\n## Windows that trajectories could share\n",
        "A window cut short at an event is one trajectory's own.\n",
        *table(("modes", "scene", "windows a cycle", "cut short", "events a cycle"), shared),
        f"\nOver the 80 points of `manifests/flex80.toml` {100 * cut[len(cut) // 2]:.0f} % of all windows are cut short "
        f"(median; {100 * cut[0]:.0f} to {100 * cut[-1]:.0f} %).",
    ]
    keep(out, text, raw=raw)


if __name__ == "__main__":
    main(*sys.argv[1:])

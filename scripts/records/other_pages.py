#!/usr/bin/env python3
"""Writes the figures of single sections of docs/ from the records `fmu`, `run-up`, `columns` and `flagship` under benches/runs/.

    .venv/bin/python scripts/records/other_pages.py           rewrites those parts
    .venv/bin/python scripts/records/other_pages.py --check   status 1 if a page differs
"""

import sys
from statistics import median

from records import link, load, percent, table, write_blocks


def fmu() -> list[str]:
    """docs/fmu.md: time of a step."""
    record = load("fmu", "record.json")
    rows = [
        (f"{1e3 * row['step']:g} ms", f"{row['events'] / row['steps']:.1f}", *(f"{1e6 * row[key]:.0f} µs" for key in ("median", "p9999", "worst")))
        for row in record["rows"]
    ]
    return [
        f"Time of a step with 40 modes that rattle, in {record['rows'][0]['steps'] / 1e6:g} million steps on one core of a shared {record['cpu']} ({link('fmu')}):",
        "",
        *table(["step", "events", "median", "99.99 %", "worst"], rows)[:-1],
    ]


def run_up() -> list[str]:
    """docs/run-ups.md: processor time of a run-up."""
    record = load("run-up", "record.json")
    rows = [(row["case"], f"{median(row['seconds'][-1]):.2f} s") for row in record["rows"]]
    return [f"Processor time of `manifests/run-up.toml` ({link('run-up')}):", "", *table(["recorded", "time"], rows)[:-1]]


def columns() -> list[str]:
    """docs/theory/propagation.md: speed-up of trajectories as columns of one product."""
    raw = load("columns", "raw.json")
    counts = raw["columns"]
    times = {row["modes"]: [time[0] for time in row["rattle"][0]["cycle_ns"]] for row in raw["structured"]}
    gain = lambda n, place: counts[place] * times[n][0] / times[n][place]  # noqa: E731
    words = {4: "four", 8: "eight"}
    rows = [(words[count], *(f"{gain(n, place):.1f}" for n in times)) for place, count in enumerate(counts) if count in words]
    cut = sorted(point[3] / point[2] for point in raw["plane"])
    middle, four = cut[len(cut) // 2], counts.index(4)
    shared = {n: 1 / (middle + (1 - middle) / gain(n, four)) for n in times}
    dense = [4 * row["product_ns"][0][0] / row["product_ns"][four][0] for row in raw["dense"] if row["set"].startswith("768")]
    return [
        f"The gain would be small ({link('columns', text='measured')}). The table has the gain if all columns share every window, its contact and its "
        "events:",
        "",
        *table(["columns", *(f"{n} modes" for n in times)], rows),
        f"A window cut at an event belongs to one trajectory. These are {100 * middle:.0f} % of all windows over the plane of `flex80.toml` (median, "
        f"with a range of {100 * cut[0]:.0f} to {100 * cut[-1]:.0f} %). Suppose that trajectories could share all other windows. Four trajectories "
        f"would then gain {', '.join(f'{gain:.1f} at {n} modes' for n, gain in shared.items())}. Dense operators from memory gain "
        f"{', '.join(f'{gain:.1f}' for gain in dense)} times with four columns.",
    ]


def tolerances() -> list[str]:
    """docs/tolerances.md: cost of samples, and rattle beside a count of independent drives."""
    record = load("flagship", "record.json")
    seconds = [(words, f"{time:.0f} s") for words, time in record["seconds"].items() if "tolerances.toml" in words]
    kinds = {"few": "samples", "many": "samples", "counted": "drives of independent random numbers"}
    first = record["rattle"][0]
    return [
        f"Processor time on one core of a shared {record['cpu']} ({link('flagship')}):",
        "",
        *table(["job", "time"], seconds),
        "Probability that the teeth part [%], with 95 % intervals:",
        "",
        *table(
            ["speed", *(f"{first[kind]['drives']} {words}" for kind, words in kinds.items())],
            [(f"{row['rpm']} rpm", *(percent(row[kind]) for kind in kinds)) for row in record["rattle"]],
        )[:-1],
    ]


if __name__ == "__main__":
    write_blocks("docs/tolerances.md", {"flagship": tolerances}, sys.argv[1:])
    write_blocks("docs/fmu.md", {"steps": fmu}, sys.argv[1:])
    write_blocks("docs/run-ups.md", {"time": run_up}, sys.argv[1:])
    write_blocks("docs/theory/propagation.md", {"columns": columns}, sys.argv[1:])

"""Runs flex80 on one thread and on more, in turn, and writes raw.json and summary.md.

    .venv/bin/python scripts/records/record_scaling.py benches/runs/NAME
"""

import json
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

import polars as pl
from records import ATLAS, ROOT, keep, processor

# Runs per number of threads, by kernel.
REPEATS = {"volterra": 3, "closed_modes": 2}
# Columns about the place and time of a computation, not its results.
NOT_PHYSICS = ["wall_time", "worker", "numa_node"]


def manifest(kernel):
    text = (ROOT / "manifests/flex80.toml").read_text()
    text, found = re.subn(r'(?m)^kernel = "volterra".*$', f'kernel = "{kernel}"', text)
    assert found == 1
    return text


def run(path, out, threads):
    subprocess.run(
        [ATLAS, "run", path, "--out", out, "--quiet", "--overwrite", "--threads", str(threads)],
        check=True,
    )
    record = json.loads((out / "run.json").read_text())
    points = pl.read_parquet(out / "points.parquet").sort("point_id")
    found = {
        "wall": record["totals"]["wall_time"],
        "in_points": points["wall_time"].sum(),
        "placement": record["placement"],
        "load": os.getloadavg()[0],
    }
    return found, points.drop(NOT_PHYSICS)


def numbers_of_threads():
    cores = len(os.sched_getaffinity(0))
    threads = [1]
    while threads[-1] * 2 < cores:
        threads.append(threads[-1] * 2)
    return threads + [cores] if cores > 1 else threads


def row(kernel, threads, runs, alone):
    wall = statistics.median(run["wall"] for run in runs)
    inside = statistics.median(run["in_points"] for run in runs)
    idle = 1 - inside / (threads * wall)
    gain = statistics.median(run["wall"] for run in alone) / wall
    slower = inside / statistics.median(run["in_points"] for run in alone)
    cells = [
        kernel,
        str(threads),
        f"{wall:.2f}",
        f"{gain:.2f}",
        f"{100 * gain / threads:.0f} %",
        f"{slower:.2f}",
        f"{100 * idle:.1f} %",
    ]
    return "| " + " | ".join(cells) + " |"


def summary(raw):
    lines = [
        "# What more threads gain",
        "",
        f"{raw['processor']}, {raw['cores']} cores, atlas {raw['commit']}; the 80 points of",
        "`manifests/flex80.toml`, one worker per core; medians of "
        + ", ".join(f"{count} ({kernel})" for kernel, count in REPEATS.items())
        + " runs, numbers of threads in turn.",
        f"Load of the machine over a minute, before the first run: {raw['load']:.1f}.",
        "",
        "| kernel | threads | wall [s] | speed-up | efficiency | a point takes longer by | without a point |",
        "|---|---|---|---|---|---|---|",
    ]
    for kernel, by_threads in raw["runs"].items():
        for threads, runs in by_threads.items():
            lines.append(row(kernel, int(threads), runs, by_threads["1"]))
    lines += [
        "",
        "*A point takes longer by*: the time spent in points, over that on one thread: caches, memory",
        "and clock are shared. *Without a point*: the part of the workers' time that no point took, start,",
        "tables and the wait for the last points included. Every run gave the same bits in every physics",
        "column.",
        "",
    ]
    return "\n".join(lines)


def main(folder):
    raw = {
        "processor": processor(),
        "cores": len(os.sched_getaffinity(0)),
        "commit": folder.name.rsplit("-", 1)[-1],
        "load": os.getloadavg()[0],
        "runs": {},
    }
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        for kernel, repeats in REPEATS.items():
            path = work / f"{kernel}.toml"
            path.write_text(manifest(kernel))
            runs = {str(threads): [] for threads in numbers_of_threads()}
            reference = None
            for _ in range(repeats):
                for threads in runs:
                    found, points = run(path, work / "out", int(threads))
                    reference = points if reference is None else reference
                    assert points.equals(reference), f"{kernel}: {threads} threads"
                    runs[threads].append(found)
            raw["runs"][kernel] = runs
    keep(folder, summary(raw), raw=raw)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))

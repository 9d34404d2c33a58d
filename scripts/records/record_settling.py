"""Runs flex80 with verified error bars, as a survey, and integrated to the end, in turn, and writes summary.md.

    .venv/bin/python scripts/records/record_settling.py benches/runs/NAME [TURNS]

Integrated to the end: without a search for orbits, with transients of 6000 mesh cycles.
"""

import pathlib
import statistics
import sys
import tempfile

import numpy as np
import polars as pl
from records import ATLAS, ROOT, keep, processor_time, table, this_run

CASES = {
    "verified": [],
    "survey": ["analyses.lyapunov.effort=survey"],
    "integrated": ["run.transient=6000", "run.settle=false"],
}


def run(settings, out):
    """Processor time of a run on one thread [s]."""
    changes = [argument for setting in settings for argument in ("--set", setting)]
    command = [ATLAS, "run", ROOT / "manifests/flex80.toml", "--out", out, "--quiet", "--overwrite", "--threads", "1", *changes]
    return processor_time(command, cwd=out.parent)


def found(points):
    """What one run says of the plane."""
    chaotic = points["class"] == "chaotic"
    return {
        "points": len(points),
        "not_ok": int((points["status"] != "ok").sum()),
        "chaotic": int(chaotic.sum()),
        "cycles": int(points["cycles"].sum()),
        "lambda_stderr": points["lambda_stderr"].filter(chaotic).max(),
        "twins_disagree": int((~points["twin_agrees"].drop_nulls()).sum()),
        "energy_residual": points["energy_residual"].max(),
    }


def apart(one, other):
    """How far two runs are from each other."""
    both = ((one["class"] == "chaotic") & (other["class"] == "chaotic")).to_numpy()
    settled = ((one["class"] != "chaotic") & (one["class"] == other["class"])).to_numpy()
    gap = np.abs(one["lambda_max"].to_numpy() - other["lambda_max"].to_numpy())
    error = np.hypot(one["lambda_stderr"].to_numpy(), other["lambda_stderr"].to_numpy())
    return {
        "same_class": int(((one["class"] == other["class"]) & one["period"].eq_missing(other["period"])).sum()),
        "settled": int(settled.sum()),
        "settled_lambda": float(gap[settled].max()),
        "chaotic": int(both.sum()),
        "chaotic_in_errors": float((gap / error)[both].max()),
    }


def main(folder, turns="3"):
    seconds = {name: [] for name in CASES}
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        for _ in range(int(turns)):
            for name, settings in CASES.items():
                seconds[name].append(run(settings, work / name))
        points = {name: pl.read_parquet(work / name / "points.parquet").sort("point_id") for name in CASES}
    record = {
        **this_run(),
        "seconds": {name: statistics.median(times) for name, times in seconds.items()},
        "turns": seconds,
        "runs": {name: found(own) for name, own in points.items()},
        "against_verified": {name: apart(points["verified"], points[name]) for name in CASES if name != "verified"},
    }
    keep(folder, summary(record), record=record)


def summary(record):
    rows = [
        ("processor time on one thread [s], median", *(f"{time:.1f}" for time in record["seconds"].values())),
        *((words, *(f"{own[key]:.2g}" if isinstance(own[key], float) else own[key] for own in record["runs"].values()))
          for key, words in [
              ("cycles", "mesh cycles"), ("chaotic", "chaotic points"), ("not_ok", "points with another status than ok"),
              ("lambda_stderr", "largest standard error of a chaotic λ [1/cycle]"),
              ("twins_disagree", "twins that disagree"), ("energy_residual", "largest energy residual"),
          ]),
        *((words, "", *(f"{own[key]:.2g}" if isinstance(own[key], float) else own[key] for own in record["against_verified"].values()))
          for key, words in [
              ("same_class", "points of the class and period of the verified run"),
              ("settled_lambda", "largest difference of λ of points that settle in both [1/cycle]"),
              ("chaotic_in_errors", "largest difference of λ of points chaotic in both, in standard errors"),
          ]),
    ]  # fmt: skip
    return [
        "# flex80 with verified error bars, as a survey, and integrated to the end",
        "",
        f"`scripts/record settling`, commit {record['commit'][:8]}, {record['cpu']}, load average {record['load']} at the end. "
        f"Medians of {len(record['turns']['verified'])} runs in turn, user and system time.",
        "",
        *table(["", *CASES], rows),
    ]


if __name__ == "__main__":
    main(*sys.argv[1:])

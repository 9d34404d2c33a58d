"""Runs flex80 with and without quick settling, in turn, and writes summary.md.

    .venv/bin/python scripts/records/record_settling.py benches/runs/NAME
"""

import json
import pathlib
import platform
import re
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np
import polars as pl

ROOT = pathlib.Path(__file__).resolve().parents[2]
ATLAS = ROOT / "target/release/atlas"
REPEATS = 5


def integrated_to_the_end(text):
    text = re.sub(r'name = "flex80"', 'name = "flex80-integrated"', text)
    text, found = re.subn(r"(?m)^transient = .*$", "transient = 6000\nsettle = false", text)
    assert found == 1
    return text


def run(manifest, out, threads):
    clock = time.perf_counter()
    subprocess.run(
        [ATLAS, "run", manifest, "--out", out, "--quiet", "--overwrite", "--threads", str(threads)],
        check=True,
    )
    return time.perf_counter() - clock


def processor():
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor()


def main(folder):
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        flex80 = ROOT / "manifests/flex80.toml"
        long = work / "integrated.toml"
        long.write_text(integrated_to_the_end(flex80.read_text()))
        times = {"settled": [], "integrated": [], "settled on 2 threads": []}
        for _ in range(REPEATS):
            times["settled"].append(run(flex80, work / "settled", 1))
            times["integrated"].append(run(long, work / "integrated", 1))
            times["settled on 2 threads"].append(run(flex80, work / "two", 2))
        read = lambda name: pl.read_parquet(work / name / "points.parquet").sort("point_id")
        a, b, two = read("settled"), read("integrated"), read("two")

    periodic = (a["class"] != "chaotic").to_numpy()
    own = [n for n in a.columns if n not in ("wall_time", "worker", "numa_node")]
    assert a.select(own).equals(two.select(own)), "threads change results"
    gap = np.abs(a["lambda_max"].to_numpy() - b["lambda_max"].to_numpy())
    error = np.hypot(a["lambda_stderr"].to_numpy(), b["lambda_stderr"].to_numpy())
    median = {name: statistics.median(values) for name, values in times.items()}
    cycles = lambda t, mask: int(t["cycles"].to_numpy()[mask].sum())
    wall = lambda t, mask: float(t["wall_time"].to_numpy()[mask].sum())
    record = {
        "cpu": processor(),
        "points": len(a),
        "cycles": int(a["cycles"].sum()),
        "seconds": median,
        "settled_ratio": wall(b, periodic) / wall(a, periodic),
        "same_class": int(((a["class"] == b["class"]) & a["period"].eq_missing(b["period"])).sum()),
        "settled_lambda_difference": float(gap[periodic].max()),
        "twins_disagree": int((~a["twin_agrees"].drop_nulls()).sum()),
        "lambda_stderr": float(a["lambda_stderr"].to_numpy()[~periodic].max()),
        "energy_residual": float(a["energy_residual"].max()),
        "runs": times,
    }
    rows = [
        ("points of the same class and period", f"{record['same_class']} of {len(a)}"),
        ("settled points", str(int(periodic.sum()))),
        ("largest difference of their λ", f"{gap[periodic].max():.1e}"),
        ("largest difference of chaotic λ, in standard errors",
            f"{(gap / error)[~periodic].max():.2f}"),
        ("mesh cycles, settled / integrated to the end", f"{a['cycles'].sum()} / {b['cycles'].sum()}"),
        ("share of cycles saved", f"{1 - a['cycles'].sum() / b['cycles'].sum():.2f}"),
        ("cycles of the settled points",
            f"{cycles(a, periodic)} / {cycles(b, periodic)}"),
        ("run time on one core [s], medians", f"{median['settled']:.2f} / {median['integrated']:.2f}"),
        ("ratio of run times", f"{median['integrated'] / median['settled']:.1f}"),
        ("ratio over the settled points", f"{wall(b, periodic) / wall(a, periodic):.1f}"),
        ("ratio over the chaotic points", f"{wall(b, ~periodic) / wall(a, ~periodic):.1f}"),
        ("two threads [s], median; same results", f"{median['settled on 2 threads']:.2f}"),
        ("largest standard error of a chaotic λ",
            f"{a['lambda_stderr'].to_numpy()[~periodic].max():.4f}"),
        ("largest energy residual", f"{a['energy_residual'].max():.1e}"),
    ]
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    text = "# flex80, settled quickly and integrated to the end over 6000 cycles\n\n"
    text += f"{processor()}; {REPEATS} runs of each in turn.\n\n| | |\n|---|---|\n"
    text += "".join(f"| {name} | {value} |\n" for name, value in rows)
    (folder / "summary.md").write_text(text)
    (folder / "record.json").write_text(json.dumps(record, indent=1) + "\n")
    print(text)


if __name__ == "__main__":
    main(*sys.argv[1:])

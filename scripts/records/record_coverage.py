"""Runs points from independent starts and writes how often their error bars hold.

    .venv/bin/python scripts/records/record_coverage.py benches/runs/NAME [--starts 60] [--points NAME,...] [--no-lives]

A start is a half gap changed by one part in 10^9 times its number: chaos forgets it within the transient.
The truth of a point is the mean over 75 other starts of 40 000 cycles each, weighted by the chaotic cycles
of each. `z` is (estimate - truth) over the claimed standard error.
"""

import argparse
import json
import pathlib
import subprocess
import tempfile
import time

import numpy as np
import polars as pl
from records import ATLAS, ROOT, keep, output, processor
from scipy.stats import t as student

TRUTH_STARTS, TRUTH_CYCLES = 75, 40_000

FLEX80 = "manifests/flex80.toml"
TIER = "manifests/tiers/translational.toml"
POINTS = {
    "t1200": (TIER, 0.05, 1200, 1e-5),
    "t1000": (TIER, 0.05, 1000, 1e-5),
    **{f"a{speed}": (FLEX80, 0.2643, speed, 1e-5) for speed in (1100, 1000, 1200, 1300)},
    **{f"b{speed}": (FLEX80, 0.1214, speed, 1e-5) for speed in (900, 1100)},
    "oscillator": ("tests/manifests/oscillator.toml", 7.5398223686155035, 6.283185307179586, 0.6),
    "train": ("manifests/trains/two-stage.toml", 0.05, 837.758041, None),
}
STATISTICS = {
    "lambda": "lambda_max",
    "rms": "deflection_rms",
    "force": "force_std",
    "impact": "impact_velocity",
    "h1": "harmonics",
}


def run(point, numbers, out, settings):
    manifest, load, speed, gap = POINTS[point]
    with tempfile.TemporaryDirectory() as work:
        grid = pathlib.Path(work) / "points.csv"
        near = lambda value, number: repr(value * (1 + 1e-9 * number))
        if gap is None:
            lines = ["load,speed"] + [f"{near(load, n)},{speed}" for n in numbers]
        else:
            lines = ["load,speed,mesh.half_gap"] + [f"{load},{speed},{near(gap, n)}" for n in numbers]
        grid.write_text("\n".join(lines) + "\n")
        command = [ATLAS, "run", ROOT / manifest, "--out", out, "--quiet", "--overwrite",
                   "--set", f'grid={{points="{grid}"}}']
        for key, value in settings.items():
            command += ["--set", f"{key}={value}"]
        code = subprocess.run([str(part) for part in command], cwd=work).returncode
        assert code in (0, 3), code
    return pl.read_parquet(pathlib.Path(out) / "points.parquet").sort("point_id")


def values(row, name):
    """Estimate and standard error of a statistic of a chaotic row; None if it has none."""
    column = STATISTICS[name]
    if row["class"] not in ("chaotic", "transient_chaos"):
        return None
    value, error = row[column], row["lambda_stderr" if column == "lambda_max" else f"{column}_stderr"]
    if isinstance(value, list):
        value, error = value[0], error and error[0]
    return None if value is None or error is None else (value, error)


def truth_of(rows, name):
    found = [(values(row, name), row["chaos_cycles"]) for row in rows.iter_rows(named=True)]
    found = [(pair[0], weight) for pair, weight in found if pair and weight]
    if not found:
        return None
    x, w = np.array([f[0] for f in found]), np.array([f[1] for f in found], float)
    mean = np.average(x, weights=w)
    error = np.sqrt(np.average((x - mean) ** 2, weights=w) / max(len(x) - 1, 1))
    return mean, error, w.sum()


def lives(work):
    """Lifetimes of chaos from flex80 and from other trajectories of 400 000 cycles per point."""
    command = [ATLAS, "run", ROOT / FLEX80, "--out", work / "flex80", "--quiet", "--overwrite"]
    code = subprocess.run([str(part) for part in command], cwd=work).returncode
    assert code in (0, 3), code
    stated = pl.read_parquet(work / "flex80/points.parquet").filter(pl.col("chaos_cycles").is_not_null())
    grid = work / "lives.csv"
    rows = [f"{row['load']},{row['speed']},{1e-5 * (1 + 5e-7)!r}" for row in stated.iter_rows(named=True)]
    grid.write_text("\n".join(["load,speed,mesh.half_gap", *rows]) + "\n")
    command = [ATLAS, "run", ROOT / FLEX80, "--out", work / "long", "--quiet", "--overwrite",
               "--set", f'grid={{points="{grid}"}}', "--set", "run.cycles=400000",
               "--set", "analyses.lyapunov={twin=false}", "--set", "analyses.nvh.harmonics=0"]
    code = subprocess.run([str(part) for part in command], cwd=work).returncode
    assert code in (0, 3), code
    long = pl.read_parquet(work / "long/points.parquet").sort("point_id")
    lines = ["", "## Lives of chaos", "",
             "Every row of flex80 that saw chaos, against other trajectories over 400 000 cycles. A row is wrong where "
             "the 95 % interval of the long run does not meet its own.", "",
             "| load | speed | class | life | interval | long: exits, cycles | interval | |", "|---|---|---|---|---|---|---|---|"]
    wrong = 0
    number = lambda value: "" if value is None else f"{value:.0f}"
    for row, other in zip(stated.sort("point_id").iter_rows(named=True), long.iter_rows(named=True)):
        low, high = row["chaos_lifetime_low"], row["chaos_lifetime_high"] or np.inf
        seen = other["chaos_cycles"] is not None
        other_low, other_high = (other["chaos_lifetime_low"], other["chaos_lifetime_high"] or np.inf) if seen else (0, np.inf)
        bad = other_high < low or other_low > high
        wrong += bad
        lines.append(f"| {row['load']:.4f} | {row['speed']:.0f} | {row['class']} | {number(row['chaos_lifetime'])} | {low:.0f} … {high:.0f} "
                     f"| {other['chaos_exits']}, {other['chaos_cycles']} | {other_low:.0f} … {other_high:.0f} | {'wrong' if bad else ''} |")
    lines.append(f"\n{wrong} of {len(stated)} rows are wrong.")
    print(lines[-1], flush=True)
    return lines


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--starts", type=int, default=60)
    parser.add_argument("--points", default=",".join(POINTS))
    parser.add_argument("--no-lives", dest="lives", action="store_false", help="leave out the lives of chaos")
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    table, summary = [], []
    clock = time.perf_counter()
    with tempfile.TemporaryDirectory() as work:
        for point in asked.points.split(","):
            out = pathlib.Path(work) / point
            rule = {"analyses.lyapunov": '{stop_at_stderr=0.01, twin=false}', "run.cycles": 160_000}
            fixed = {"analyses.lyapunov": '{twin=false}', "run.cycles": TRUTH_CYCLES}
            rows = run(point, range(1, 1 + asked.starts), out, rule)
            true = run(point, range(1001, 1001 + TRUTH_STARTS), out, fixed)
            classes = dict(rows["class"].value_counts().iter_rows())
            statuses = dict(rows["status"].value_counts().iter_rows())
            left = {"exits": int(rows["chaos_exits"].sum() or 0), "chaotic cycles": int(rows["chaos_cycles"].sum() or 0),
                     "true exits": int(true["chaos_exits"].sum() or 0), "true cycles": int(true["chaos_cycles"].sum() or 0)}
            summary.append({"point": point, "classes": classes, "statuses": statuses, **left,
                            "cycles": float(rows["cycles"].mean()), "seconds": float(rows["wall_time"].mean())})
            for name in STATISTICS:
                known = truth_of(true, name)
                if known is None:
                    continue
                mean, error, _ = known
                # Only rows with status ok: the errors of others are not reliable.
                ok = rows.filter(pl.col("status") == "ok").iter_rows(named=True)
                found = [pair for pair in (values(row, name) for row in ok) if pair]
                if len(found) < 5:
                    continue
                x, claimed = np.array(found).T
                z = (x - mean) / claimed
                with_truth = np.hypot(claimed, error)
                held = np.abs(x - mean) <= student.ppf(0.975, 20) * with_truth
                table.append({
                    "point": point, "statistic": name, "rows": len(x), "truth": mean, "truth_error": error,
                    "mean": x.mean(), "claimed": claimed.mean(),
                    "scatter_over_claimed": x.std(ddof=1) / np.sqrt(np.mean(claimed**2)),
                    "holds": held.mean(), "holds_196": (np.abs(x - mean) <= 1.96 * claimed).mean(),
                    "mean_z": z.mean(), "truth_error_over_claimed": error / claimed.mean(),
                })
            print(json.dumps(summary[-1]), flush=True)
            for row in table:
                if row["point"] == point:
                    print("   ", {k: round(v, 4) if isinstance(v, float) and abs(v) > 1e-3 else v for k, v in row.items()}, flush=True)
    frame = pl.DataFrame(table)
    frame.write_csv(asked.folder / "coverage.csv")
    lines = ["# How often error bars hold", "",
             f"Commit {output('git', 'rev-parse', '--short', 'HEAD')}, {processor()}, {time.perf_counter() - clock:.0f} s. "
             f"`scripts/record coverage --starts {asked.starts}`: rows with status `ok` of that many independent starts, "
             "`stop_at_stderr = 0.01`, budget 160 000 cycles; truth from 3 million cycles.", "",
             "| point | statistic | rows | scatter over claimed | 95 % intervals hold | mean error in claimed errors | error of the truth in claimed errors |",
             "|---|---|---|---|---|---|---|"]
    for row in table:
        lines.append(f"| {row['point']} | {row['statistic']} | {row['rows']} | {row['scatter_over_claimed']:.2f} | {row['holds']:.2f} | {row['mean_z']:+.2f} | {row['truth_error_over_claimed']:.2f} |")
    lines += ["", "| point | classes | statuses | cycles a row | exits, chaotic cycles | the same of the truth |", "|---|---|---|---|---|---|"]
    words = lambda counts: ", ".join(f"{count} {name}" for name, count in counts.items())
    for row in summary:
        lines.append(f"| {row['point']} | {words(row['classes'])} | {words(row['statuses'])} | {row['cycles']:.0f} "
                     f"| {row['exits']}, {row['chaotic cycles']} | {row['true exits']}, {row['true cycles']} |")
    if asked.lives:
        with tempfile.TemporaryDirectory() as work:
            lines += lives(pathlib.Path(work))
    keep(asked.folder, lines, points=summary)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Runs the paper's cases of motion, each on one line of action and on two, with half gaps of 9 and 10 µm
(the paper gives neither), and records the figures of docs/replication.md.

    .venv/bin/python scripts/records/record_replication.py benches/runs/NAME
"""

import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path
from statistics import median

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
import pandas as pd  # noqa: E402
import scipy.linalg as la  # noqa: E402

from records import ATLAS, ROOT, keep, processor  # noqa: E402

LINES = {"one line": "same_line", "mirrored": "mirrored"}
GAPS = {"9 µm": "9 um", "10 µm": "10 um"}
VARIANTS = [f"{line}, {gap}" for line in LINES for gap in GAPS]

# Okabe & Ito, one colour per variant.
COLOURS = dict(zip(VARIANTS, ["#E69F00", "#D55E00", "#56B4E9", "#0072B2"], strict=True))

# The paper's speed of strong rattle, which it calls nominal [rad/s].
NOMINAL = 1200.0
STRONG = ["grid.load=0.05", 'grid.speed="1200 rad/s"']


class Runner:
    """Runs manifests of this tree with changed keys."""

    def __init__(self, work: Path):
        self.work = work
        self.count = 0

    def __call__(self, command, manifest, changes=(), arguments=()):
        """Folder of the results."""
        self.count += 1
        out = self.work / str(self.count)
        sets = [argument for change in changes for argument in ("--set", change)]
        folders = ["--tables", self.work / "tables", "--out", out]
        done = subprocess.run(
            [ATLAS, command, ROOT / "manifests" / manifest, *sets, *folders, *arguments],
            text=True, capture_output=True,
        )  # fmt: skip
        if done.returncode != 0:
            sys.exit(f"{manifest} {changes}:\n{done.stderr}")
        return out

    def points(self, manifest, changes=(), arguments=()):
        out = self("run", manifest, changes, ["--quiet", *arguments])
        return pd.read_parquet(out / "points.parquet"), out


def of_variant(variant: str) -> list[str]:
    line, gap = variant.split(", ")
    return [f'mesh.coast_flank="{LINES[line]}"', f'mesh.half_gap="{GAPS[gap]}"']


def plane(run: Runner, variant: str) -> dict:
    """The 80 points of figure 9."""
    points, _ = run.points("flex80.toml", of_variant(variant))
    chaotic = points["class"] == "chaotic"
    highest = points.loc[points["lambda_max"].idxmax()]
    near = points[(points["speed"] - NOMINAL).abs() == (points["speed"] - NOMINAL).abs().min()]
    return {
        "points": len(points),
        "stable_period_1": int(((points["class"] == "periodic") & (points["period"] == 1)).sum()),
        "chaotic": int(chaotic.sum()),
        "lambda_max": highest["lambda_max"],
        "lambda_stderr": highest["lambda_stderr"],
        "lambda_at": [highest["speed"], highest["load"]],
        "rms_mean": points["deflection_rms"].mean(),
        "force_over_load": near.sort_values("load")[["load", "force_peak"]].to_numpy().tolist(),
    }


def sweep(run: Runner, variant: str) -> dict:
    """Figure 10: speeds from 0.55 to 1.70 of the nominal one."""
    points, _ = run.points("speed-sweep.toml", of_variant(variant))
    ratio = points["speed"] / NOMINAL
    window = points[(ratio > 1.20) & (ratio < 1.26)]
    return {
        "points": len(points),
        "chaotic": int((points["class"] == "chaotic").sum()),
        "window_lambda": window["lambda_max"].min(),
        "window_chaotic": f"{int((window['class'] == 'chaotic').sum())} of {len(window)}",
    }


def probes(run: Runner, variant: str) -> dict:
    """128 starts: the window's middle, both shoulders, and the nominal speed."""
    speeds = [f'"{NOMINAL * ratio} rad/s"' for ratio in (1.0, 1.20, 1.23, 1.26)]
    changes = ["grid.load=0.05", f"grid.speed={{values=[{','.join(speeds)}]}}"]
    points, out = run.points("multistability.toml", [*of_variant(variant), *changes])
    all_probes = pd.read_parquet(out / "probes.parquet")
    attractors = pd.read_parquet(out / "attractors.parquet")
    found = all_probes.merge(attractors, on=["point_id", "attractor_id"], suffixes=("", "_of"))
    return {
        "probes": len(all_probes),
        "chaotic": int((found["class"] == "chaotic").sum()),
        "attractors": points["attractors"].tolist(),
        "lambda_in_window": points["lambda_max"].iloc[2],
    }


def modes(run: Runner, variant: str) -> dict:
    """Figures 12 and 14: number of retained modes out of 40, at the strong point and two loads."""
    points, _ = run.points("modes.toml", of_variant(variant))
    kept = points[points["model.retained"] != 30].sort_values(["load", "model.retained"])
    light, heavy = [kept[kept["load"] == load] for load in (0.05, 0.30)]
    full = [table[table["model.retained"] == 40].iloc[0] for table in (light, heavy)]
    augmented, _ = run.points("modes-mta.toml", of_variant(variant))
    twenty = augmented[(augmented["model.retained"] == 20) & (augmented["load"] == 0.05)].iloc[0]
    return {
        "retained": light["model.retained"].tolist(),
        "lambda": light["lambda_max"].tolist(),
        "rms": light["deflection_rms"].tolist(),
        "rms_augmented": twenty["deflection_rms"],
        "pp": [at["deflection_pp"] for at in full],
        "pp_over_rms": [at["deflection_pp"] / at["deflection_rms"] for at in full],
        "force_peak": [at["force_peak"] for at in full],
        "harmonics": [list(at["harmonics"]) for at in full],
    }


def horizon(run: Runner, variant: str) -> dict:
    """Figure 8: twins of 40 modes, and the convergence of the mean contact force."""
    points, out = run.points("horizon.toml", [*of_variant(variant), "grid.load=0.05"])
    point, course = points.iloc[0], pd.read_parquet(out / "horizon.parquet")
    force = course[course["quantity"] == "contact_force"]
    parted = course[course["quantity"] == "separation"]
    relative = (force["spread"] / force["value"]).to_numpy()
    slope = np.polyfit(np.log(force["cycles"]), np.log(relative), 1)[0]
    return {
        "class": point["class"],
        "lambda": point["lambda_max"],
        "horizon": number(point["horizon"]),
        "horizon_stderr": number(point["horizon_stderr"]),
        "force_stderr": relative[-1],
        "force_slope": slope,
        "force_course": [force["cycles"].tolist(), relative.tolist()],
        "separation_course": [parted["cycles"].tolist(), parted["value"].tolist()],
    }


def six(run: Runner, variant: str) -> dict:
    """Figures 7 and 11: six degrees of freedom."""
    separations = [10.0**-power for power in (6, 7, 8, 9)]
    values = ",".join(map(str, separations))
    changes = [
        *of_variant(variant),
        "grid.load=0.05",
        "analyses.horizon={twins=64, separation=1e-6, cycles=400}",
        f'grid."analyses.horizon.separation"={{values=[{values}]}}',
    ]
    points, out = run.points("orbits/strong.toml", changes)
    points = points.sort_values("analyses.horizon.separation", ascending=False)
    sparse, sparse_out = run.points("orbits/sparse.toml", [*of_variant(variant), "grid.load=0.05"])
    return {
        "lambda": points["lambda_max"].iloc[0],
        "class": points["class"].iloc[0],
        "events": points["events_per_cycle"].iloc[0],
        "separations": separations,
        "horizon": [number(value) for value in points["horizon"]],
        "strong": orbit(out, 1),
        "sparse_class": sparse["class"].iloc[0],
        "sparse": orbit(sparse_out, 2),
    }


def orbit(out: Path, period: int) -> dict | None:
    """The most stable orbit found with a period: leading multiplier, where a kick of 1e-5 is after one
    return, and by how much it grows in each of the next five."""
    orbits = pd.read_parquet(out / "orbits.parquet")
    orbits = orbits[orbits["found"] & (orbits["period"] == period) & (orbits["events"] > 0)]
    if orbits.empty:
        return None
    sizes = [np.hypot(o["multipliers_re"], o["multipliers_im"]) for _, o in orbits.iterrows()]
    # Rotation of the whole drive gives a constant pair of multipliers at one.
    rigid = lambda o: np.abs(o["multipliers_re"] + 1j * o["multipliers_im"] - 1) < 1e-6  # noqa: E731
    lead = [size[~rigid(o)].max() for size, (_, o) in zip(sizes, orbits.iterrows(), strict=True)]
    best = int(np.argmin(lead))
    o = orbits.iloc[best]
    at = int(np.argmax(np.where(rigid(o), 0, sizes[best])))
    distance = o["kick_distance"]
    return {
        "multiplier": [float(o["multipliers_re"][at]), float(o["multipliers_im"][at])],
        "modulus": float(lead[best]),
        "events": int(o["events"]),
        "orbits": len(orbits),
        "kick_first": float(distance[1]),
        "kick_after": float((distance[6] / distance[1]) ** 0.2),
    }


def number(value) -> float | None:
    return None if value is None or np.isnan(value) else float(value)


def misalignment(run: Runner) -> dict:
    """Stiffness at 1 mrad and 50 N m, by the table and with the compliance of the shafts."""
    changes = [
        'grid.speed="1200 rad/s"',
        'grid."mesh.misalignment"={values=["0 mrad", "1 mrad"]}',
        "run.cycles=400",
    ]
    found = {}
    for name, tilt in {"table": "false", "loop": "true"}.items():
        points, _ = run.points("misalignment.toml", [*changes, f"mesh.shaft_tilt={tilt}"])
        level, askew = points.sort_values("mesh.misalignment")["mesh_stiffness"]
        found[name] = askew / level - 1
    return found


def drift(run: Runner) -> dict:
    """A misalignment that drifts over five slices, compared with the same length on one slice."""
    changes = ["mesh.shaft_tilt="]
    still = 'grid."mesh.misalignment"={values=["0.1 mrad","0.1000001 mrad","0.1000002 mrad","0.1000003 mrad","0.1000004 mrad"]}'
    times = {"drifting": [], "still": []}
    for _ in range(3):
        for name, more in {"drifting": [], "still": [still]}.items():
            points, _ = run.points(
                "misalignment-drift.toml", [*changes, *more], ["--threads", "1"]
            )
            simulated = (points["cycles"] * 2 * np.pi / (20 * NOMINAL)).sum()
            times[name].append(simulated / points["wall_time"].sum())
    return {"volterra": {name: median(values) for name, values in times.items()}}


def threads(run: Runner) -> dict:
    """flex80 on one thread and on all, in turn."""
    count = len(__import__("os").sched_getaffinity(0))
    times = {1: [], count: []}
    for _ in range(5):
        for number_of, values in times.items():
            clock = time.perf_counter()
            run.points("flex80.toml", of_variant("one line, 10 µm"), ["--threads", str(number_of)])
            values.append(time.perf_counter() - clock)
    return {"threads": count, "seconds": {str(n): median(values) for n, values in times.items()}}


def modal_data() -> dict:
    """Condition of the eigenvector matrix in the paper's coordinates: modal displacements and velocities
    as they are, the neutral block split off, of the default drive's elastic modes; and `c_res k` of its twenty
    highest."""
    data = tomllib.loads((ROOT / "tests/data/default-drive.modal.toml").read_text())
    frequency, damping, mesh = (np.array(data[key]) for key in ("frequency", "damping", "mesh"))
    stiffness, contact_damping = 4e8, 1483.0
    found = {}
    for name, k, c in [("free", 0.0, 0.0), ("contact", stiffness, contact_damping)]:
        n = len(frequency)
        matrix = np.block(
            [
                [np.zeros((n, n)), np.eye(n)],
                [
                    -np.diag(frequency**2) - k * np.outer(mesh, mesh),
                    -np.diag(2 * damping * frequency) - c * np.outer(mesh, mesh),
                ],
            ]
        )
        values, vectors = la.eig(matrix)
        elastic = np.abs(values) > 1.0
        # One of each pair, as a real and an imaginary column with a joint unit length.
        chosen = elastic & (values.imag > 0)
        columns = np.concatenate([vectors[:, chosen].real, vectors[:, chosen].imag], axis=1)
        # Columns span the elastic subspace: the condition is that of its singular values.
        singular = np.linalg.svd(columns, compute_uv=False)
        found[name] = singular[0] / singular[-1]
    # The mesh flexibility of the modes above the twentieth.
    residual = stiffness * np.sum(mesh[20:] ** 2 / frequency[20:] ** 2)
    return {"conditioning": found, "residual": residual}


def waveforms(run: Runner, folder: Path) -> None:
    """Figure 14 (a): a cycle of the deflection with 15, 20 and 40 modes."""
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.2), sharex=True)
    for axis, variant in zip(axes, ["one line, 9 µm", "mirrored, 9 µm"], strict=True):
        for kept, colour in zip([15, 20, 40], ["#E69F00", "#56B4E9", "#000000"], strict=True):
            out = run(
                "trace", "modes.toml", of_variant(variant),
                ["--point", f"load=0.05,speed=1200,model.retained={kept}", "--cycles", "4"],
            )  # fmt: skip
            series = pd.read_parquet(out / "trace.parquet")
            cycles = series["cycle"] - series["cycle"].iloc[0] + series["phase"]
            axis.plot(cycles, 1e6 * series["deflection"], color=colour, label=f"{kept} modes", lw=1.2)
        axis.set_title(variant, fontsize=9)
        axis.set_xlabel("mesh cycles")
    axes[0].set_ylabel("deflection [µm]")
    axes[0].legend(fontsize=8, frameon=False)
    save(figure, folder / "waveform.png")


def pictures(record: dict, folder: Path) -> None:
    """Figures 7, 8 and 12: horizons, settling averages, orders, force over load."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.2))
    for variant in VARIANTS:
        case = record["horizon"][variant]
        label = dict(color=COLOURS[variant], label=variant)
        left.semilogy(*case["separation_course"], **label)
        right.loglog(*case["force_course"], **label)
    left.set(xlabel="mesh cycles", ylabel="separation / half gap")
    right.set(xlabel="mesh cycles averaged", ylabel="standard error / mean contact force")
    left.legend(fontsize=7, frameon=False)
    save(figure, folder / "horizon.png")

    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.2))
    for place, variant in enumerate(VARIANTS):
        colour = COLOURS[variant]
        orders = 1e6 * np.array(record["modes"][variant]["harmonics"][0])
        x = np.arange(1, len(orders) + 1) + 0.2 * (place - 1.5)
        left.bar(x, orders, width=0.2, color=colour, label=variant)
        loads, forces = np.transpose(record["plane"][variant]["force_over_load"])
        right.plot(100 * loads, forces / 1e3, "o-", ms=3, color=colour)
    left.set(xlabel="order of the mesh", ylabel="deflection [µm]")
    left.set_yscale("log")
    left.legend(fontsize=7, frameon=False)
    right.plot([5, 30], [6.0, 9.6], "kx", label="paper")
    right.set(xlabel="load [%]", ylabel="peak mesh force [kN]")
    right.legend(fontsize=7, frameon=False)
    save(figure, folder / "signatures.png")


def save(figure, path: Path) -> None:
    for axis in figure.axes:
        axis.spines[["top", "right"]].set_visible(False)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    record = {"cpu": processor(), "variants": VARIANTS}
    with tempfile.TemporaryDirectory() as work:
        run = Runner(Path(work))
        for case in (plane, sweep, probes, modes, horizon, six):
            record[case.__name__] = {}
            for variant in VARIANTS:
                record[case.__name__][variant] = case(run, variant)
                print(f"{case.__name__}, {variant}", flush=True)
        for case in (misalignment, drift, threads):
            record[case.__name__] = case(run)
            print(case.__name__, flush=True)
        record |= modal_data()
        waveforms(run, folder)
    pictures(record, folder)
    keep(folder, ["# The paper's cases of motion", "", "`scripts/record replication`; [its tables](../../../docs/replication.md#motion)."], record=record)


if __name__ == "__main__":
    main(Path(sys.argv[1]))

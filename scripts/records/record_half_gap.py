"""Which conclusions about flex80 depend on its half gap? Runs flex80.toml and gearbox.toml over the half gap and the contact
damping, and writes record.json, summary.md and half-gap.png, or the tables of docs/half-gap.md.

    .venv/bin/python scripts/records/record_half_gap.py benches/runs/NAME-COMMIT    # measures
    .venv/bin/python scripts/records/record_half_gap.py                             # writes the page from the newest record
    .venv/bin/python scripts/records/record_half_gap.py --check                     # status 1 if the page differs
"""

import json
import math
import os
import pathlib
import sys
import tempfile

import numpy as np
import polars as pl
from records import ATLAS, ROOT, keep, link, processor, processor_time, the, write_blocks

PINION, WHEEL = (f"train.shaft.{shaft}.gears.0.thinning" for shaft in (1, 2))
GAPS = {"flex80": (10, 15, 25, 40, 60, 100), "gearbox": (10, 20, 40, 77, 100)}
FEW = {"flex80": (10, 60), "gearbox": (10, 77)}
DAMPING = {"flex80": (741, 1483, 2966, 5932), "gearbox": (415, 830, 1660, 3320)}
# Damping ratios of the isolated pair: gear bodies on a rigid frame, at the mean stiffness.
RATIO = {"flex80": 0.029 / 1483, "gearbox": 0.06 / 830}
# Half gap divided by the thinning of both gears of the gearbox.
OPENS = 76.5766 / 82
# A car that surges for longer: a third of the damping of its side shafts.
SURGE = ["train.coupling.1.damping='2 N*m*s/rad'"]
FLANKS = {"mirrored": "mirrored", "same_line": "one line"}
SHORT = {
    "flex80": [
        "model.modes=20",
        "model.retained=20",
        "run.cycles=4000",
        "analyses.lyapunov={effort='survey',twin=false}",
        "analyses.poincare=",
    ],
    # Without the film of oil, which flex80 does not have either.
    "gearbox": ["analyses.lyapunov={effort='survey',twin=false}", "mesh.film=", "run.cycles=3000"],
}
VARIANTS = {"no_error": ", no imposed error", "surge": ", less surge damping"}
NO_ERROR = {
    "flex80": ["excitation.transmission_error=[]"],
    "gearbox": ["excitation.transmission_error=[]", "excitation.pitch_deviation.pinion="],
}


def gap_axis(drive, gaps):
    if drive == "flex80":
        return ["grid.'mesh.half_gap'={values=%s}" % [1e-6 * gap for gap in gaps]]
    thin = [round(1e-6 * gap / OPENS, 10) for gap in gaps]
    ripple = "excitation.torque_ripple.0.amplitude"
    return [
        f"grid.'{PINION}'={{values={thin}}}",
        f"grid.'{WHEEL}'={{values={thin}}}",
        f"grid.tied=[['speed','{ripple}'],['{PINION}','{WHEEL}']]",
    ]


def run(drive, gaps, changes, work, name):
    """Points of a run as a table with `gap` in µm, and its processor time [s]."""
    command = [ATLAS, "run", ROOT / f"manifests/{drive}.toml", "--threads", "1", "--quiet"]
    command += ["--out", work / name, "--tables", work / "tables"]
    for change in [*SHORT[drive], *gap_axis(drive, gaps), *changes]:
        command += ["--set", change]
    spent = processor_time(command, cwd=work)
    points = pl.read_parquet(work / name / "points.parquet")
    axis = 1e6 * points["mesh.half_gap"] if drive == "flex80" else 1e6 * OPENS * points[PINION]
    print(f"{drive}, {name}: {len(points)} points, {spent:.0f} s", flush=True)
    return points.with_columns(axis.round(0).alias("gap")), spent


def interval(share, speeds):
    """Wilson's 95 % interval of a share. Points of one speed resemble each other: all of them count as one point."""
    z2 = 1.96**2
    middle = (share + z2 / (2 * speeds)) / (1 + z2 / speeds)
    half = math.sqrt(z2 * (share * (1 - share) / speeds + z2 / (4 * speeds**2))) / (1 + z2 / speeds)
    return [max(0.0, middle - half), min(1.0, middle + half)]


def statistics(points):
    """One row of the table of a set of operating points."""
    kind = points["class"].to_numpy()
    chaotic = kind == "chaotic"
    good = points.filter(pl.col("deflection_rms").is_not_null() & (pl.col("status") != "diverged"))
    exponents = points.filter(pl.col("class") == "chaotic")
    top = exponents.sort("lambda_max", descending=True).head(1)
    settled = points.filter(pl.col("class").is_in(["periodic", "steady_contact"]))
    base = int(settled["period"].min()) if len(settled) else 1
    lowest, highest = points["load"].min(), points["load"].max()
    peak = lambda load: float(good.filter(pl.col("load") == load)["force_peak"].median() or math.nan)
    mean = lambda name: float(good[name].mean())
    return {
        "points": len(points),
        "chaotic": int(chaotic.sum()),
        "interval": interval(float(chaotic.mean()), points["speed"].n_unique()),
        "transient_chaos": int((kind == "transient_chaos").sum()),
        "not_converged": int((kind == "not_converged").sum()),
        "failed": len(points) - len(good),
        "one_period": int((settled["period"] == base).sum()) if len(settled) else 0,
        "without_loss": int((good["fraction_drive"] > 0.9999).sum()),
        "free": mean("fraction_free"),
        "coast": mean("fraction_coast"),
        "events": mean("events_per_cycle"),
        "rms": 1e6 * mean("deflection_rms"),
        "pp_over_rms": float((good["deflection_pp"] / good["deflection_rms"]).median()),
        "first_order": 1e6 * float(good["harmonics"].list.get(0).median()),
        "lambda": [float(top["lambda_max"][0]), float(top["lambda_stderr"][0])] if len(top) else None,
        "lambda_median": float(exponents["lambda_max"].median()) if len(top) else None,
        "peak_force": [peak(lowest), peak(highest)],
    }


def measure():
    rows, seconds = [], 0.0
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        for drive, gaps in GAPS.items():
            nominal = {"flex80": 1483, "gearbox": 830}[drive]
            cases = [(flank, flank, gaps, nominal, [f"mesh.coast_flank='{flank}'"]) for flank in FLANKS]
            cases.append(("no_error", "mirrored", FEW[drive], nominal, NO_ERROR[drive]))
            if drive == "gearbox":
                cases.append(("surge", "mirrored", FEW[drive], nominal, SURGE))
            for damping in DAMPING[drive]:
                if damping != nominal:
                    changes = [f"mesh.contact_damping='{damping} N*s/m'"]
                    cases.append(("damping", "mirrored", FEW[drive], damping, changes))
            for case, flank, own, damping, changes in cases:
                points, spent = run(drive, own, changes, work, f"{drive}-{case}-{damping}")
                seconds += spent
                for gap in own:
                    found = statistics(points.filter(pl.col("gap") == gap))
                    about = {"drive": drive, "case": case, "flank": flank, "gap": gap, "damping": damping}
                    rows.append(about | found)
    return {"cpu": processor(), "load_average": os.getloadavg()[0], "seconds": seconds, "rows": rows}


def standard_stiffness():
    """Mesh stiffness of the gearbox's pair by ISO 6336-1, method B, b c_γα [N/m]."""
    teeth, shift, contact_ratio, width, helix = (29, 42), (0.166, 0.0098), 1.530, 17, math.radians(18)
    base = math.asin(math.sin(helix) * math.cos(math.radians(20)))
    first, second = (z / (math.cos(base) ** 2 * math.cos(helix)) for z in teeth)
    x1, x2 = shift
    compliance = 0.04723 + 0.15551 / first + 0.25791 / second - 0.00635 * x1 - 0.11654 * x1 / first
    compliance += -0.00193 * x2 - 0.24188 * x2 / second + 0.00529 * x1**2 + 0.00182 * x2**2
    single = 0.8 * 0.975 * math.cos(helix) / compliance  # C_M, and C_B of a dedendum of 1.25 modules
    return 1e6 * width * single * (0.75 * contact_ratio + 0.25)


def by_hand():
    """The gearbox of the manifest, compared with a specialist's hand calculation."""
    base_radius, width, torque, drag = 28.4782e-3, 17.0, 190.0, 0.05 * 29 / 42
    short = ["run.settle=false", "run.transient=29", "run.cycles=58", "run.audit_cycles=0", "analyses.lyapunov="]
    loaded = [*short, "grid.load=1", "train.bearing_load=1"]
    plain = [f"train.shaft.{shaft}.gears.0.tip_relief=" for shaft in (1, 2)]
    plain.append("train.shaft.1.gears.0.lead_crowning=0")
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        points, _ = run("gearbox", (77,), [], work, "grid")
        drawn, _ = run("gearbox", (77,), loaded, work, "drawn")
        involute, _ = run("gearbox", (77,), [*loaded, *plain], work, "involute")
    asked = (points["load"].to_numpy() * torque + drag) / base_radius
    ratio = points["force_mean"].to_numpy() / asked
    return {
        "points": len(points),
        "mean_force": [float(ratio.min()), float(ratio.max())],
        "rated_load": 2e3 * torque / (29 * 2 / math.cos(math.radians(18))) / width,
        "peak_load": 1e-3 * float(points["force_peak"].max()) / (1e-3 * width),
        "stiffness_iso": standard_stiffness(),
        "stiffness": [float(involute["mesh_stiffness"][0]), float(drawn["mesh_stiffness"][0])],
        "deflection": 1e6 * torque / base_radius / float(drawn["mesh_stiffness"][0]),
        "error_pp": [1e6 * float(involute["transmission_error_pp"][0]), 1e6 * float(drawn["transmission_error_pp"][0])],
        "light_stiffness": [float(points["mesh_stiffness"].min()), float(points["mesh_stiffness"].max())],
    }


def hand_table(own):
    iso, (involute, drawn) = own["stiffness_iso"], own["stiffness"]
    low, high = own["mean_force"]
    rows = [
        ("mean mesh force over load and drag divided by the base radius, all points", f"{low:.3f} … {high:.3f}"),
        ("peak mesh force per face width, all points [N/mm]", f"{own['peak_load']:.0f}"),
        ("the same at the rated torque, which the teeth bear [N/mm]", f"{own['rated_load']:.0f}"),
        ("mesh stiffness by ISO 6336-1, method B [N/m]", f"{iso:.3g}"),
        ("computed at the rated torque, involutes without relief and crowning [N/m]", f"{involute:.3g} ({100 * (involute / iso - 1):+.1f} %)"),
        ("computed at the rated torque, as drawn [N/m]", f"{drawn:.3g} ({100 * (drawn / iso - 1):+.1f} %)"),
        ("computed at 0.5 % and 5 % of it, as drawn [N/m]", " and ".join(f"{k:.2g}" for k in own["light_stiffness"])),
        ("approach of the gears at the rated torque [µm]", f"{own['deflection']:.0f}"),
        ("its peak to peak, without and with relief and crowning [µm]", " and ".join(f"{e:.2f}" for e in own["error_pp"])),
    ]  # fmt: skip
    return ["| gearbox.toml | |", "|---|---|", *(f"| {name} | {value} |" for name, value in rows), ""]


def cells(row):
    low, high = row["interval"]
    chaotic = f"{row['chaotic']} of {row['points']}, {100 * low:.0f} … {100 * high:.0f} %"
    top = "–" if row["lambda"] is None else f"{row['lambda'][0]:.3f} ± {row['lambda'][1]:.3f}"
    light, heavy = row["peak_force"]
    return [
        chaotic,
        str(row["not_converged"] + row["transient_chaos"]),
        str(row["one_period"]),
        str(row["without_loss"]),
        f"{100 * row['free']:.0f} / {100 * row['coast']:.1f}",
        f"{row['events']:.2f}",
        f"{row['rms']:.3g}",
        f"{row['pp_over_rms']:.1f}",
        f"{row['first_order']:.3g}",
        top,
        f"{1e-3 * light:.2f} / {1e-3 * heavy:.2f}",
    ]


HEAD = [
    "chaotic, 95 %", "undecided", "period of the excitation", "never apart", "free / coast [%]", "events a cycle", "RMS [µm]",
    "p-p/RMS", "first order [µm]", "largest λ", "peak force [kN]",
]  # fmt: skip


def table(first, rows):
    lines = ["| " + " | ".join([*first, *HEAD]) + " |", "|---" * (len(first) + len(HEAD)) + "|"]
    lines += ["| " + " | ".join([*names, *cells(row)]) + " |" for names, row in rows]
    return lines + [""]


def tables(record):
    text = []
    for drive in GAPS:
        rows = [row for row in record["rows"] if row["drive"] == drive]
        text += [f"`{drive}.toml` over the half gap:", ""]
        over = [row for row in rows if row["case"] in FLANKS]
        text += table(["coast flanks", "half gap [µm]"], [([FLANKS[row["flank"]], str(row["gap"])], row) for row in over])
        text += [f"`{drive}.toml` over the contact damping, coast flanks mirrored, and variants:", ""]
        few = [row for row in rows if row["flank"] == "mirrored" and row["gap"] in FEW[drive]]
        few.sort(key=lambda row: (row["case"] in VARIANTS, row["case"] if row["case"] in VARIANTS else "", row["gap"], row["damping"]))
        name = lambda row: f"{RATIO[drive] * row['damping']:.3f}{VARIANTS.get(row['case'], '')}"
        text += table(["ζ of the pair", "half gap [µm]"], [([name(row), str(row["gap"])], row) for row in few])
    return text


def draw(record, path):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(2, 2, figsize=(9.6, 6.4), sharex=True, layout="constrained")
    colours = {"flex80": "tab:red", "gearbox": "tab:blue"}
    for drive in GAPS:
        for flank, dash in (("mirrored", "o-"), ("same_line", "s--")):
            rows = [row for row in record["rows"] if row["drive"] == drive and row["case"] == flank]
            gaps = [row["gap"] for row in rows]
            shares = np.array([row["chaotic"] / row["points"] for row in rows])
            bars = [shares - [row["interval"][0] for row in rows], [row["interval"][1] for row in rows] - shares]
            style = {"color": colours[drive], "label": f"{drive}, {FLANKS[flank]}"}
            axes[0, 0].errorbar(gaps, 100 * shares, yerr=100 * np.clip(bars, 0, None), fmt=dash, capsize=3, **style)
            axes[0, 1].plot(gaps, [100 * row["coast"] for row in rows], dash, **style)
            axes[1, 0].plot(gaps, [row["rms"] for row in rows], dash, **style)
            known = [row for row in rows if row["lambda"]]
            bars = [row["lambda"][1] for row in known]
            values = [row["lambda"][0] for row in known]
            axes[1, 1].errorbar([row["gap"] for row in known], values, yerr=bars, fmt=dash, capsize=3, **style)
    labels = ["chaotic points [%], 95 %", "time in coast contact [%]", "mean RMS of δ [µm]", "largest λ [1/cycle]"]
    for axis, label in zip(axes.flat, labels, strict=True):
        axis.set_ylabel(label)
        axis.set_xscale("log")
        axis.grid(alpha=0.3)
    ticks = [10, 20, 40, 77, 100]
    for axis in axes[1]:
        axis.set_xlabel("half gap [µm]")
        axis.set_xticks(ticks, [str(tick) for tick in ticks])
        axis.minorticks_off()
    axes[0, 1].legend(fontsize=8)
    figure.savefig(path, dpi=150)


def page():
    """The part of docs/half-gap.md that is from a record."""
    record = json.loads((the("half-gap") / "record.json").read_text())
    picture = f"../benches/runs/{the('half-gap').name}/half-gap.png"
    own = [f"Figures from {link('half-gap')}.", "", *hand_table(record["by_hand"]), *tables(record)]
    return [*own, f"![Chaos, coast contact, deflection and λ over the half gap]({picture})"]


def summary(record):
    return f"""# Two drives over half gap and contact damping

`scripts/record half-gap`: {record["seconds"]:.0f} s of processor time on one core of a shared {record["cpu"]}, load average
{record["load_average"]:.1f}. `flex80.toml` has 20 of its 40 modes here and at most 4000 measured cycles per point. Error bars are those of a
survey, with unknown coverage. Undecided points are neither called chaotic nor regular, or some of their trajectories left chaos.

""" + "\n".join([*hand_table(record["by_hand"]), *tables(record)])


def main(arguments):
    if not arguments or arguments == ["--check"]:
        write_blocks("docs/half-gap.md", {"half-gap": page}, arguments)
        return
    record = measure() | {"by_hand": by_hand()}
    keep(arguments[0], summary(record), record=record)
    draw(record, pathlib.Path(arguments[0]) / "half-gap.png")


if __name__ == "__main__":
    main(sys.argv[1:])

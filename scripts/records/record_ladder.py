#!/usr/bin/env python3
"""Turns the output of the ladder bench into a recorded run: raw JSON, summary, pictures.

    .venv/bin/python scripts/records/record_ladder.py RAW benches/runs/NAME

RAW may be the raw.json of a recorded run, whose summary and pictures are then made again.
"""

import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.ticker import NullFormatter  # noqa: E402

from records import keep, table, this_run  # noqa: E402
from replication import (  # noqa: E402
    PAPER_EVENTS,
    PAPER_REDUCTION,
    PAPER_STEPS,
    significant,
)

# Okabe & Ito.
COLOURS = {
    "stepping": "#555555",
    "dyadic": "#E69F00",
    "hermite": "#009E73",
    "spectral": "#0072B2",
    "fused": "#D55E00",
    "volterra": "#000000",
    "Dormand-Prince 5(4)": "#CC79A7",
    "extrapolation, order 14": "#56B4E9",
}

def size(count: float) -> str:
    for unit in ["B", "KiB", "MiB"]:
        if count < 1024:
            break
        count /= 1024
    return f"{significant(count)} {unit}"


def ours(value: dict) -> list[str]:
    """Time, real time and work of a kernel."""
    return [
        significant(value["ns"] / 1e3),
        f"{significant(value['range'][0] / 1e3)} … {significant(value['range'][1] / 1e3)}",
        significant(value["real_time"]),
        significant(value["matvecs"]) if value["table_bytes"] else "—",
        significant(value["guard_evaluations"]) if value["table_bytes"] else "—",
        significant(value["events"]),
        size(value["table_bytes"]) if value["table_bytes"] else "—",
    ]


HEAD = ["µs a cycle", "range", "× real time", "products", "guards", "events", "tables"]


def events(record: dict) -> list[str]:
    rows = []
    for scene, kernels in record["events"].items():
        best = kernels["volterra"]["ns"]
        for name, value in kernels.items():
            paper = PAPER_EVENTS[scene].get(name)
            said = [str(v) for v in paper] if paper else ["—"] * 3
            rows.append([scene, name, *ours(value), significant(value["ns"] / best), *said])
    head = ["scene", "kernel", *HEAD, "× volterra", "paper: µs", "× real time", "products"]
    return table(head, rows)


def reduction(record: dict) -> list[str]:
    rows = []
    for variant, kernels in record["reduction"].items():
        best = kernels["volterra"]["ns"]
        for name, value in kernels.items():
            paper = PAPER_REDUCTION.get((variant, name))
            said = [str(v) for v in paper] if paper else ["—"] * 4
            rms = f"{1e6 * value['deflection_rms']:.1f}"
            rows.append([variant, name, *ours(value), rms, significant(value["ns"] / best), *said])
    head = ["variant", "kernel", *HEAD, "RMS [µm]", "× volterra"]
    head += ["paper: µs", "× real time", "products", "RMS [µm]"]
    return table(head, rows)


def steps(record: dict) -> list[str]:
    rows = []
    for modes, value in record["small_steps"].items():
        step, ratio = value["ns_a_step"], value["stepping"]["real_time"]
        structured = value["volterra"]
        rows.append(
            [
                modes,
                significant(step),
                significant(ratio),
                *(str(v) for v in PAPER_STEPS[modes]),
                significant(structured["ns"] / 1e3),
                significant(structured["real_time"]),
            ]
        )
    head = ["modes", "ns a step", "× real time", "paper: ns", "× real time"]
    return table([*head, "volterra: µs a cycle", "× real time"], rows)


def contact(record: dict) -> list[str]:
    rows = []
    for modes, value in record["contact"].items():
        for name in ["stepping", "hermite", "spectral", "fused", "volterra"]:
            rows.append([modes, name, *ours(value[name])])
    lines = table(["modes", "kernel", *HEAD], rows)
    rows = []
    for modes, value in record["contact"].items():
        jump = value["jump"]
        rows.append(
            [
                modes,
                significant(jump["ns"]),
                str(jump["products"]),
                significant(1e6 * value["fused"]["ns"] / jump["ns"]),
                significant(jump["against_integrating"]),
                significant(value["segments_against_fused"]),
                significant(value["volterra_against_fused"]),
            ]
        )
    head = [
        "modes", "10⁶ cycles [ns]", "products", "× integrating them", "against integrating (relative)",
        "segments against fused [gaps]", "volterra against fused [gaps]",
    ]  # fmt: skip
    return lines + table(head, rows)


def conditioning(record: dict) -> list[str]:
    found = record["conditioning"]
    spectral = record["reduction"]["40 modes"]["spectral"]
    contact, free = (significant(v) for v in found["condition"])
    rebuilt = significant(max(found["reconstruction"]))
    mib = {name: size(found[f"{name}_bytes"]) for name in ["spectral", "fused", "dyadic", "volterra"]}
    ratio = found["dyadic_bytes"] / found["spectral_bytes"]
    rows = [
        ["state dimension", str(found["dimension"]), "81"],
        ["spectral tables", mib["spectral"], "18 MB"],
        ["fused tables", mib["fused"], "—"],
        ["dyadic tables", f"{mib['dyadic']} ({ratio:.1f} × spectral)", "190 MB (10.6 ×)"],
        ["structured tables", mib["volterra"], "—"],
        ["condition number, free flight", free, "8.1e5"],
        ["condition number, contact", contact, "1e3"],
        ["rebuilt propagator", rebuilt, "1.5e-11"],
        ["events a cycle", significant(spectral["events"]), "2.7–2.9"],
    ]
    for name, value in found["against"].items():
        paper = {"fused": "4.0e-15", "small steps, 100 ns": "5.1e-6 … 1e-3"}.get(name, "—")
        rows.append([f"spectral against {name}, one cycle [gaps]", significant(value), paper])
    return table(["property", "here", "paper"], rows)


def precision(record: dict) -> list[str]:
    found = record["single_precision"]
    cells = []
    for scene, path in found["path"].items():
        double, single = (path[kernel]["ns"] for kernel in ("spectral", "spectral, single precision"))
        errors = [f"{path[key]:.1e}" for key in ("state_error", "event_time_error")]
        others = f"{path['cycles_with_other_events']} of {path['compared_cycles']}"
        cells.append([scene, significant(double / 1e3), significant(single / 1e3), significant(double / single), *errors, others])
    head = ["one cycle", "64 bits [µs]", "32 bits [µs]", "ratio", "state error [half gaps]", "event time error [cycles]", "cycles with other events"]
    times = [
        [place, significant(double), significant(single), significant(double / single)]
        for place, (double, single) in found["product_ns"].items()
    ]
    return [
        "The event path with products in 32 bits; the search for events keeps 64.",
        "",
        *table(head, cells),
        "One product of dimension 96:",
        "",
        *table(["operators in turn", "64 bits [ns]", "32 bits [ns]", "ratio"], times),
    ]


def solvers(record: dict) -> list[str]:
    """Best time of each solver at an error, and the kernels."""
    samples = record["work_precision"]["samples"]
    cycles = record["work_precision"]["cycles"]
    rows = []
    for sample in samples:
        tolerance = sample.get("tolerance")
        rows.append(
            [
                sample["solver"],
                "—" if tolerance is None else f"{tolerance:.0e}",
                significant(sample["ns"] / 1e3 / cycles),
                f"{sample['error']:.1e}",
            ]
        )
    return table(["solver", "tolerance", "µs a cycle", "error [gaps]"], rows)


def threads(record: dict) -> list[str]:
    found = record["threads"]
    one = found["1"]
    rows = [
        [count, *(f"{rates[k] / 1e3:.1f} ({rates[k] / one[k]:.2f} ×)" for k in one)]
        for count, rates in found.items()
    ]
    return table(["threads", *(f"{k} [10³ cycles/s]" for k in one)], rows)


def ratios(record: dict) -> list[str]:
    """Structured kernel, compared with the dense ones on the hardest case."""
    kernels, found = record["reduction"]["40 modes"], record["conditioning"]
    base = kernels["volterra"]["ns"]
    return [
        "At 40 modes with sixty segments the structured kernel is "
        f"{kernels['spectral']['ns'] / base:.0f} times as fast as `spectral` and "
        f"{kernels['fused']['ns'] / base:.0f} times as fast as `fused`; its tables are "
        f"{found['spectral_bytes'] / found['volterra_bytes']:.0f} and "
        f"{found['fused_bytes'] / found['volterra_bytes']:.0f} times smaller.",
        "",
    ]


def style() -> None:
    plt.rcParams.update({"font.size": 9, "svg.fonttype": "path"})
    plt.rcParams.update({"axes.spines.top": False, "axes.spines.right": False})


def reduction_picture(record: dict, file: Path) -> None:
    """Figure 3: real time by variant, the paper's and ours."""
    rungs = [
        ("40 modes\nspectral", "40 modes", "spectral"),
        ("20 modes\nspectral", "20 modes", "spectral"),
        ("20 modes + MTA\nspectral", "20 modes + MTA", "spectral"),
        ("20 modes + MTA\nfused", "20 modes + MTA", "fused"),
        ("20 modes + MTA\nvolterra", "20 modes + MTA", "volterra"),
        ("40 modes\nvolterra", "40 modes", "volterra"),
    ]
    figure, axes = plt.subplots(figsize=(8.5, 4.2), layout="constrained")
    for at, (_, variant, kernel) in enumerate(rungs):
        value = record["reduction"][variant][kernel]
        speed = value["real_time"]
        axes.bar(at + 0.18, speed, 0.34, color=COLOURS[kernel])
        axes.text(at + 0.18, speed * 1.08, f"{significant(speed)} ×", ha="center", va="bottom")
        paper = PAPER_REDUCTION.get((variant, kernel))
        if paper:
            axes.bar(at - 0.18, paper[1], 0.34, color="#bbbbbb", hatch="///", edgecolor="white")
            axes.text(at - 0.18, paper[1] * 1.08, f"{paper[1]} ×", ha="center", va="bottom", color="#555555")
    axes.axhline(1, color="#555555", lw=0.8, ls="--")
    axes.text(-0.55, 1.06, "real time", va="bottom", color="#555555")
    axes.set_yscale("log")
    axes.set_ylim(0.1, 4 * max(v["volterra"]["real_time"] for v in record["reduction"].values()))
    axes.set_xticks(range(len(rungs)), [name for name, *_ in rungs])
    axes.set_ylabel("speed [× real time]")
    axes.set_title("Hatched: the paper, one core at 2.4 GHz. Solid: this machine, one core.", loc="left")
    figure.savefig(file, dpi=150)
    plt.close(figure)


def ceiling_picture(record: dict, file: Path) -> None:
    """Figure 1: speed of a mesh cycle by the demands of the motion."""
    period = record["work_precision"]["period"]
    contact, events, reduction = record["contact"], record["events"], record["reduction"]
    # (demand of the motion, the paper's × real time, kernels here)
    layers = [
        ("10⁶ cycles of\ncontact at once\n2 modes", 1e6 * period / 634e-9, {"fused": 1e15 * period / contact["2"]["jump"]["ns"]}),
        ("contact\na cycle\n2 modes", period / 61e-9, {"fused": contact["2"]["fused"]["real_time"]}),
        ("contact\na cycle\n40 modes", 487.7, {"fused": contact["40"]["fused"]["real_time"]}),
        ("events\n6 modes", PAPER_EVENTS["strong"]["spectral"][1], of(events["strong"], "spectral", "volterra")),
        ("events\n40 modes", PAPER_REDUCTION["40 modes", "spectral"][1], of(reduction["40 modes"], "spectral", "volterra")),
        ("events\n20 modes + MTA", PAPER_REDUCTION["20 modes + MTA", "fused"][1], of(reduction["20 modes + MTA"], "fused", "volterra")),
    ]  # fmt: skip
    figure, axes = plt.subplots(figsize=(8.5, 4.2), layout="constrained")
    for at, (_, paper, here) in enumerate(layers):
        axes.plot(at - 0.15, paper, "s", color="#888888", label="the paper" if at == 0 else None)
        above = {"xytext": (0, 6), "textcoords": "offset points", "ha": "center", "va": "bottom"}
        axes.annotate(significant(paper, 2), (at - 0.15, paper), color="#666666", **above)
        for (kernel, speed), beside in zip(sorted(here.items(), key=lambda own: own[1]), ("top", "bottom")):
            axes.plot(at + 0.05, speed, "o", color=COLOURS[kernel])
            text = f"{kernel} {significant(speed, 2)}"
            axes.text(at + 0.12, speed, text, ha="left", va="center" if len(here) == 1 else beside, color=COLOURS[kernel])
    axes.axhline(1, color="#555555", lw=0.8, ls="--")
    axes.text(-0.65, 1.15, "real time", va="bottom", color="#555555")
    axes.set_yscale("log")
    axes.set_xlim(-0.7, len(layers))
    axes.set_xticks(range(len(layers)), [name for name, *_ in layers])
    axes.set_ylabel("speed [× real time]")
    axes.set_title("Squares: the paper, one core at 2.4 GHz. Circles: this machine, one core.", loc="left")
    figure.savefig(file, dpi=150)
    plt.close(figure)


def of(kernels: dict, *names: str) -> dict:
    """× real time of some kernels."""
    return {name: kernels[name]["real_time"] for name in names}


def threads_picture(record: dict, file: Path) -> None:
    """Figure 5c: cycles per second by number of threads."""
    found = record["threads"]
    counts = [int(count) for count in found]
    figure, axes = plt.subplots(figsize=(6.2, 4.2), layout="constrained")
    for kernel in ["volterra", "fused", "spectral"]:
        rates = [found[str(n)][kernel] for n in counts]
        axes.plot(counts, rates, "o-", color=COLOURS[kernel], ms=5)
        axes.plot(counts, [rates[0] * n for n in counts], ":", color=COLOURS[kernel], lw=1)
        axes.text(
            counts[-1] * 1.06, rates[-1], f"{kernel}\n{rates[-1] / rates[0]:.2f} ×",
            color=COLOURS[kernel], va="center",
        )  # fmt: skip
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.set_xticks(counts, [str(n) for n in counts])
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlim(counts[0] / 1.1, counts[-1] * 1.45)
    axes.set_xlabel("threads")
    axes.set_ylabel("mesh cycles a second, all threads")
    axes.set_title("40 modes on one shared table; dotted: in proportion", loc="left")
    axes.grid(True, color="#dddddd", lw=0.5)
    figure.savefig(file, dpi=150)
    plt.close(figure)


def precision_picture(record: dict, file: Path) -> None:
    """Figure 6: time against error in constant contact."""
    found = record["work_precision"]
    cycles = found["cycles"]
    figure, axes = plt.subplots(figsize=(8, 4.8), layout="constrained")
    for solver in ["Dormand-Prince 5(4)", "extrapolation, order 14"]:
        samples = [s for s in found["samples"] if s["solver"] == solver]
        x = [s["error"] for s in samples]
        y = [s["ns"] / 1e3 / cycles for s in samples]
        axes.plot(x, y, "o-", color=COLOURS[solver], ms=4, lw=1.2)
        axes.annotate(
            solver, (x[-1], y[-1]), (9, 0), textcoords="offset points",
            color=COLOURS[solver], va="center",
        )  # fmt: skip
    marks = {"spectral": "s", "fused": "D", "stepping": "x", "volterra": "^", "jump": "*"}
    for sample in found["samples"]:
        name = sample["solver"]
        if name in marks:
            colour = COLOURS.get(name, COLOURS["fused"])
            x, y = sample["error"], sample["ns"] / 1e3 / cycles
            axes.plot([x], [y], marks[name], color=colour, ms=7)
            text = "jump: Φ⁵ in two products" if name == "jump" else name
            axes.annotate(
                text, (x, y), (9, 0), textcoords="offset points", color=colour, va="center",
            )  # fmt: skip
    period = found["period"] * 1e6
    axes.axhline(period, color="#999999", lw=0.8)
    axes.text(1e-17, period * 0.9, "real time", color="#777777", ha="right", va="top")
    axes.set(xscale="log", yscale="log", xlim=(10, 1e-17))
    axes.set_xlabel(f"error of the state after {cycles} cycles, energy norm [half gaps]")
    axes.set_ylabel("time of one mesh cycle [µs]")
    axes.set_title("Constant contact, 40 modes", loc="left")
    axes.grid(which="major", color="#dddddd", lw=0.5)
    axes.set_axisbelow(True)
    figure.savefig(file, dpi=150)
    plt.close(figure)


def summary(name: str, record: dict) -> str:
    run = record["run"]
    seconds = sum(run["seconds"].values())
    lines = [
        f"# {name}",
        "",
        f"`scripts/record ladder` on {run['cpu']}, {run['cores']} cores, {run['instructions']}, load average",
        f"{run['load']} at the end; commit {run['commit'][:8]}. Medians of processor time over",
        f"nine rounds in which the kernels of a scene run in turn; {seconds:.0f} s. One core unless said otherwise.",
        "The paper's are of one core of a Xeon E5-2680 v4 at 2.4 GHz. `products`: of a dense operator",
        "with a state, a mesh cycle; `guards`: evaluations of a guard at a time.",
        "",
        *ratios(record),
        "![How fast a mesh cycle can be passed](ceiling.png)",
        "",
        "## Small steps of 100 ns, rattle (Table 1)",
        "",
        *steps(record),
        "## Event location at six modes, 5 % load (Table 2)",
        "",
        *events(record),
        "## From forty modes to fused runs, 1200 rad/s, sixty segments (Table 3, Figure 3)",
        "",
        *reduction(record),
        "![Speed by variant](reduction.png)",
        "",
        "## The hardest case (Table 4)",
        "",
        *conditioning(record),
        "## Constant contact, friction 0.1",
        "",
        *contact(record),
        "## Work and precision in constant contact (Figure 6)",
        "",
        *solvers(record),
        "![Work and precision](work-precision.png)",
        "",
        "## Threads on one table (Figure 5c)",
        "",
        *threads(record),
        "![Threads](threads.png)",
        "",
        "## Single precision",
        "",
        *precision(record),
    ]
    return "\n".join(lines).rstrip() + "\n"


def main() -> None:
    raw, folder = Path(sys.argv[1]), Path(sys.argv[2])
    record = json.loads(raw.read_text())
    if "run" not in record:
        own = {"instructions": record.pop("instructions"), "seconds": record.pop("seconds")}
        record["run"] = {"command": "scripts/record ladder", **this_run(), **own}
    keep(folder, summary(folder.name, record), raw=record)
    style()
    ceiling_picture(record, folder / "ceiling.png")
    reduction_picture(record, folder / "reduction.png")
    threads_picture(record, folder / "threads.png")
    precision_picture(record, folder / "work-precision.png")


if __name__ == "__main__":
    main()

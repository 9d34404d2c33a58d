#!/usr/bin/env python3
"""Turns the output of benches/peers into a recorded run: raw JSON, summary, picture.

    .venv/bin/python scripts/records/record_peers.py RAW benches/runs/NAME
"""

import json
import math
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.patheffects import withStroke  # noqa: E402

from records import keep, output, this_run  # noqa: E402

TARGETS = [1e-6, 1e-9, 1e-12]

# In the order of the table. Colours of Okabe & Ito.
STYLES = {
    "volterra": ("#000000", "o", "-"),
    "DOP853": ("#D55E00", "s", "-"),
    "Verner 9(8)": ("#009E73", "D", "-"),
    "DOP853 (crate)": ("#E69F00", "s", "--"),
    "CVODE Adams": ("#0072B2", "^", "-"),
    "CVODE Adams (Debian)": ("#0072B2", "^", ":"),
    "CVODE BDF": ("#56B4E9", "v", "--"),
    "stepping": ("#CC79A7", "x", ":"),
    "reference": ("#777777", "*", ":"),
}


def front(samples: list[dict]) -> list[tuple[float, float]]:
    """(error, time) of the samples that no other sample beats in both, the most accurate first."""
    best: list[tuple[float, float]] = []
    for error, time in sorted((s["error"], s["time"]) for s in samples):
        if not best or time < best[-1][1]:
            best.append((error, time))
    return best


def time_at(samples: list[dict], target: float) -> float | None:
    """Least time for an error of at most `target`, log-log between samples."""
    points = front(samples)
    if not points or points[0][0] > target:
        return None
    for (e0, t0), (e1, t1) in zip(points, points[1:]):
        if e1 > target:
            share = math.log(target / e0) / math.log(e1 / e0)
            return t0 * (t1 / t0) ** share
    return points[-1][1]


def by_solver(record: dict, problem: str) -> dict[str, list[dict]]:
    """Successful samples of each solver."""
    found: dict[str, list[dict]] = {name: [] for name in STYLES}
    for sample in record["samples"]:
        if sample["problem"] == problem and "error" in sample:
            found[sample["solver"]].append(sample)
    return found


def power(value: float) -> str:
    """One digit and an exponent without leading zeros."""
    digit, exponent = f"{value:.0e}".split("e")
    return f"{digit}e{int(exponent)}"


def significant(value: float) -> str:
    """Three digits without an exponent."""
    digits = max(0, 2 - math.floor(math.log10(value)))
    return f"{value:.{digits}f}"


def table_of(record: dict, problem: str) -> list[str]:
    """Time at equal error, and its ratio to the structured kernel."""
    solvers = by_solver(record, problem)
    base = [time_at(solvers["volterra"], target) for target in TARGETS]
    heads = "".join(f" µs at {power(t)} | × volterra |" for t in TARGETS)
    lines = [f"| solver |{heads} least error |", "|---" * (2 + 2 * len(TARGETS)) + "|"]
    for name, samples in solvers.items():
        if not samples:
            continue
        cells = []
        for target, reference in zip(TARGETS, base):
            time = time_at(samples, target)
            if time is None or reference is None:
                cells += ["—", "—"]
            else:
                cells += [significant(time * 1e6), significant(time / reference)]
        least = min(s["error"] for s in samples)
        lines.append(f"| {name} | " + " | ".join(cells) + f" | {power(least)} |")
    return lines


def picture(record: dict, folder: Path) -> None:
    """Work-precision diagrams, one panel per problem."""
    plt.rcParams.update({"font.size": 9, "svg.fonttype": "path"})
    problems = record["problems"]
    figure, axes = plt.subplots(1, len(problems), figsize=(11, 5.2), sharey=True)
    for panel, (axis, problem) in enumerate(zip(axes, problems)):
        ends = []
        for name, samples in by_solver(record, problem["name"]).items():
            if not samples:
                continue
            colour, marker, line = STYLES[name]
            samples = sorted(samples, key=lambda s: s["setting"])
            error = [s["error"] for s in samples]
            time = [s["time"] * 1e6 for s in samples]
            axis.plot(error, time, line, color=colour, marker=marker, ms=4, lw=1.2)
            ends.append((name, colour, error[0], time[0]))
        period = problem["period"] * 1e6
        axis.axhline(period, color="0.6", lw=0.8, zorder=0)
        axis.text(2e-18, period * 0.93, "real time", color="0.4", ha="right", va="top")
        axis.set(xscale="log", yscale="log", xlim=(10, 1e-18))
        axis.set_xticks([10.0**-e for e in range(0, 16, 3)])
        axis.set_xlabel("error of the state after 5 cycles, energy norm [half gaps]")
        axis.set_title(f"{problem['name']}, {problem['events_per_cycle']:.1f} events a cycle")
        axis.grid(which="major", color="0.9", lw=0.6)
        axis.set_axisbelow(True)
        if panel == 0:
            axis.set_ylabel("time of one mesh cycle [µs]")
        label(axis, ends)
    figure.tight_layout()
    figure.savefig(folder / "work-precision.png", dpi=150)
    figure.savefig(folder / "work-precision.svg", metadata={"Date": None})
    plt.close(figure)


def label(axis, ends: list[tuple[str, str, float, float]]) -> None:
    """Names at the accurate end of each curve, moved apart where they would overlap."""
    apart = 1.4
    placed: list[tuple[float, float]] = []
    for name, colour, error, time in sorted(ends, key=lambda e: e[3]):
        left = name == "stepping"
        # Beside the markers of curves that end close by, not on them.
        beside = [e for _, _, e, t in ends if error / 30 < e <= error and t / 1.5 < time < t * 1.5]
        place = error * 2.6 if left else min(beside) / 2.6
        height = time
        for other_place, other in sorted(placed, key=lambda p: p[1]):
            near = abs(math.log10(place / other_place)) < 5
            if near and other / apart < height < other * apart:
                height = other * apart
        placed.append((place, height))
        # White edges keep names legible over lines.
        axis.text(
            place,
            height,
            name,
            color=colour,
            ha="right" if left else "left",
            va="center",
            path_effects=[withStroke(linewidth=3, foreground="white")],
        )


def main() -> None:
    record = json.loads(Path(sys.argv[1]).read_text())
    folder = Path(sys.argv[2])
    sundials = output("dpkg-query", "-W", "-f=${Version}", "libsundials-dev") or "unknown"
    compiler = output("rustc", "--version")
    record = {"command": "scripts/record peers", **this_run(), "compiler": compiler, "sundials": sundials, "unit": "s", **record}

    worst = max(p["uncertainty"] for p in record["problems"])
    lines = [
        f"# {folder.name}",
        "",
        f"`scripts/record peers` on {record['cpu']}, {record['cores']} cores, load average {record['load']} at the",
        f"end; commit {record['commit'][:8]}, {record['compiler']}, SUNDIALS {sundials}. One process,",
        "one thread; medians of processor time over repetitions, set-up outside the clock.",
        "",
        "Time of one mesh cycle at equal error, interpolated between settings: the error is that of",
        f"the state after {record['cycles']} rattling cycles (energy norm, half gaps; the largest of",
        f"{record['problems'][0]['stretches']} stretches) against the extended-precision run, which is certain within {power(worst)}.",
        "A dash: not reached at any setting tried.",
        "",
    ]
    for problem in record["problems"]:
        lines += [f"## {problem['name']}, {problem['events_per_cycle']:.1f} events a cycle", ""]
        lines += table_of(record, problem["name"]) + [""]
    lines += [
        "All solvers get the same right-hand side with O(N) work and restart at events and, in contact,",
        "at steps of the stiffness. Right-hand side, `DOP853`, `Verner 9(8)` and CVODE's vector sums",
        "are compiled for this processor; `CVODE Adams (Debian)` is the package with its own, otherwise",
        "the same. Adams runs with fixed-point iteration, BDF with the analytic dense Jacobian, both",
        "with CVODE's root finding. `DOP853 (crate)` is that of the `differential-equations` crate;",
        "`DOP853` is the same method without its allocations. `volterra` is the default kernel of atlas,",
        "`stepping` its fixed-step oracle, `reference` its Gauss integrator.",
        "",
        "![Work and precision](work-precision.png)",
        "",
    ]
    keep(folder, lines, raw=record)
    picture(record, folder)


if __name__ == "__main__":
    main()

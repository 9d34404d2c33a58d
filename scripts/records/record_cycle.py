#!/usr/bin/env python3
"""Collects a benchmark run: raw JSON, a summary with tables, and a picture.

    .venv/bin/python scripts/records/record_cycle.py benches/runs/NAME
"""

import json
import math
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from records import ROOT, keep, table, this_run  # noqa: E402

MODES = [2, 6, 12, 20, 40, 81, 160, 320, 640]
FITTED = [n for n in MODES if n >= 20]
SCENES = {
    "load-0.05": "rattle, 5 % load",
    "load-0.3": "rattle, 30 % load",
    "constant-contact": "constant contact",
}
COUNTERS = [
    "windows",
    "partial_windows",
    "certified",
    "bisections",
    "newton_steps",
    "events",
]
BYTES = 8


def estimates() -> dict[str, dict[str, float]]:
    """Median and its 95 % interval in nanoseconds, by benchmark."""
    found = {}
    for file in sorted((ROOT / "target/criterion").glob("*/*/*/new/estimates.json")):
        name = json.loads((file.parent / "benchmark.json").read_text())["full_id"]
        median = json.loads(file.read_text())["median"]
        interval = median["confidence_interval"]
        found[name] = {
            "median": median["point_estimate"],
            "low": interval["lower_bound"],
            "high": interval["upper_bound"],
        }
    return found


def exponent(times: dict[int, float]) -> float:
    """Least-squares slope of log time over log N."""
    x = [math.log(n) for n in times]
    y = [math.log(t) for t in times.values()]
    mx, my = sum(x) / len(x), sum(y) / len(y)
    top = sum((a - mx) * (b - my) for a, b in zip(x, y))
    return top / sum((a - mx) ** 2 for a in x)


class Run:
    """A run and its tables."""

    def __init__(self, found: dict, facts: dict) -> None:
        self.found, self.facts = found, facts

    def ns(self, name: str) -> float:
        return self.found[name]["median"]

    def by_modes(self, prefix: str) -> dict[int, float]:
        """Median [ns] by number of modes, where measured."""
        return {n: self.ns(f"{prefix}/{n}") for n in MODES if f"{prefix}/{n}" in self.found}

    def exponent(self, scene: str) -> float:
        times = self.by_modes(f"cycle/{scene}")
        return exponent({n: times[n] for n in FITTED})

    def scene_rows(self, names: list[str]) -> list[list[str]]:
        """Time and work of a cycle of each scene."""
        rows = []
        for name in names:
            work, time = self.facts["work"][name], self.found[name]
            rows.append(
                [
                    name.removeprefix("cycle/"),
                    f"{time['median'] / 1e3:.2f}",
                    f"{time['low'] / 1e3:.2f} … {time['high'] / 1e3:.2f}",
                    f"{work['period_ns'] / time['median']:.0f}",
                    f"{time['median'] / work['windows']:.0f}",
                    str(work["cells"]),
                    *(f"{work[key]:.2f}" for key in COUNTERS),
                ]
            )
        return rows

    def roofline_rows(self) -> list[list[str]]:
        """A full window in contact, compared with reads of its tables and with its multiply-adds."""
        rows = []
        for n in MODES:
            work = self.facts["work"][f"cycle/constant-contact/{n}"]
            window = self.ns(f"cycle/constant-contact/{n}") / work["windows"]
            numbers = work["numbers_per_window"]
            reading = self.facts["reading_tables_ns"][str(n)]
            least = numbers / self.facts["multiply_adds_per_ns"]
            rows.append(
                [
                    str(n),
                    f"{window:.0f}",
                    str(numbers),
                    f"{BYTES * numbers / 1024:.0f}",
                    f"{numbers / window:.1f}",
                    f"{BYTES * numbers / window:.0f}",
                    f"{100 * least / window:.0f}",
                    f"{100 * reading / window:.0f}",
                ]
            )
        return rows

    def cost_rows(self) -> list[list[str]]:
        """Set-up and tangents, compared with a cycle at 5 % load."""
        base, one, eight = (
            self.by_modes(p) for p in ("cycle/load-0.05", "tangents/1", "tangents/8")
        )
        tables = self.by_modes("set-up/tables")
        return [
            [
                str(n),
                f"{base[n] / 1e3:.2f}",
                f"{(one[n] - base[n]) / 1e3:.2f}",
                f"{(eight[n] - base[n]) / 8e3:.2f}",
                f"{tables[n] / 1e3:.1f}",
                f"{tables[n] / base[n]:.1f}",
            ]
            for n in MODES
        ]

    def other_rows(self) -> list[list[str]]:
        """Other kernels and instruction sets, compared with the default."""
        rows = []
        for name, time in self.found.items():
            group, kind, parameter = name.split("/")
            if group == "others":
                base = f"cycle/load-0.05/{parameter}"
            elif group == "set":
                base = "cycle/" + {"quiet": "constant-contact"}.get(parameter, parameter) + "/40"
            else:
                continue
            ratio = time["median"] / self.ns(base)
            rows.append([f"{kind}/{parameter}", f"{time['median'] / 1e3:.2f}", f"{ratio:.2f}"])
        return rows


def summary(name: str, record: dict, run: Run) -> str:
    facts = run.facts
    head = [
        "scene", "µs a cycle", "95 % interval", "× real time", "ns a window", "cells",
        "windows", "cut", "certified", "bisections", "root steps", "events",
    ]  # fmt: skip
    modes = [f"cycle/{scene}/{n}" for scene in SCENES for n in MODES]
    rest = [s for s in facts["work"] if s not in modes]
    fits = [f"{label} N^{run.exponent(scene):.2f}" for scene, label in SCENES.items()]
    bandwidth = ", ".join(f"{v:.0f} GB/s from {k}" for k, v in facts["bytes_per_ns"].items())
    lines = [
        f"# {name}",
        "",
        f"`{record['command']}` on {record['cpu']}, {facts['instructions']}, one core, commit",
        f"{record['commit'][:8]}. Medians of one run. Work is counted per mesh cycle; a scene is",
        "a drive at 1200 rad/s by number of modes N, or the drive of 40 modes.",
        "",
        "![Time of a mesh cycle](cost.png)",
        "",
        f"Fitted growth from N = {FITTED[0]} to {FITTED[-1]}: {'; '.join(fits)}.",
        "",
        "## Number of modes",
        "",
        *table(head, run.scene_rows(modes)),
        "## Speed, load and the place of the stiffness step at 40 modes",
        "",
        *table(head, run.scene_rows(rest)),
        "## Full windows in contact against the machine",
        "",
        "Every number of the tables is read once a window for one multiply-add. Ceilings of one",
        f"core: {facts['multiply_adds_per_ns']:.1f} multiply-adds a nanosecond from registers;",
        f"{bandwidth}. Shares: what the multiply-adds alone, and what reading a buffer as",
        "large as the tables alone, would take of a window's time.",
        "",
        *table(
            ["N", "ns a window", "multiply-adds", "KiB", "multiply-adds/ns", "GB/s",
             "% multiply-adds", "% reading"],
            run.roofline_rows(),
        ),
        "## Tangents and set-up at 5 % load",
        "",
        *table(
            ["N", "µs a cycle", "first tangent [µs]", "each of eight [µs]", "set-up [µs]",
             "set-up in cycles"],
            run.cost_rows(),
        ),
        "## Other kernels and instruction sets",
        "",
        "Ratio to the structured kernel with the best instruction set in the same scene.",
        "",
        *table(["benchmark", "µs a cycle", "ratio"], run.other_rows()),
    ]  # fmt: skip
    return "\n".join(lines)


def label_ends(axes: plt.Axes, ends: list[tuple[str, str, float, float]]) -> None:
    """Writes every line's name (text, colour, x, y) beside its end, clear of one another."""
    below = 0.0
    for text, colour, x, y in sorted(ends, key=lambda end: end[3]):
        below = y if x < MODES[-1] else max(y, 1.9 * below)
        axes.text(1.15 * x, below, text, color=colour, va="center")


def picture(run: Run, file: Path) -> None:
    """Time of a cycle and time of a full window over N."""
    blue, red, green, grey = "#0072B2", "#D55E00", "#009E73", "#555555"
    plt.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False})
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.4), layout="constrained")

    def draw(axes: plt.Axes, lines: list[tuple[str, str, str, dict[int, float]]]) -> None:
        for _, colour, style, values in lines:
            axes.plot(list(values), list(values.values()), style, color=colour, markersize=4)
        ends = [(text, colour, *list(values.items())[-1]) for text, colour, _, values in lines]
        label_ends(axes, ends)

    cycles = []
    for (scene, label), colour, style in zip(SCENES.items(), [blue, red, green], ["o-", "s-", "^-"]):
        times = {n: t / 1e3 for n, t in run.by_modes(f"cycle/{scene}").items()}
        cycles.append((f"{label}\n$\\propto N^{{{run.exponent(scene):.2f}}}$", colour, style, times))
    stepping = {n: t / 1e3 for n, t in run.by_modes("others/stepping-100ns").items()}
    cycles.append(("steps of 100 ns, 5 % load", grey, "x--", stepping))
    draw(left, cycles)
    left.set_title("Mesh cycle; powers fitted from N = 20 on", loc="left")
    left.set_ylabel("time of a cycle [µs]")

    work = {n: run.facts["work"][f"cycle/constant-contact/{n}"] for n in MODES}
    window = {n: run.ns(f"cycle/constant-contact/{n}") / work[n]["windows"] for n in MODES}
    peak = run.facts["multiply_adds_per_ns"]
    adding = {n: work[n]["numbers_per_window"] / peak for n in MODES}
    reading = {n: run.facts["reading_tables_ns"][str(n)] for n in MODES}
    draw(right, [
        ("full window\nin contact", green, "^-", window),
        ("reading\nits tables", blue, "D--", reading),
        ("its multiply-adds\nat the peak rate", grey, "x:", adding),
    ])  # fmt: skip
    right.set_title("Window against the machine", loc="left")
    right.set_ylabel("time [ns]")
    for axes in (left, right):
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xticks(MODES, [str(n) for n in MODES])
        axes.minorticks_off()
        axes.set_xlim(1.7, 4000)
        axes.set_xlabel("modes N")
        axes.grid(True, color="#dddddd", linewidth=0.5)
    right.set_ylim(top=3 * window[MODES[-1]])
    figure.savefig(file, dpi=150)


def main(folder: str) -> None:
    facts = json.loads((ROOT / "target/criterion/facts.json").read_text())
    record = {"command": "cargo bench --bench cycle", **this_run(), "unit": "ns", "estimates": estimates(), "facts": facts}
    run = Run(record["estimates"], facts)
    keep(folder, summary(Path(folder).name, record, run), raw=record)
    picture(run, Path(folder) / "cost.png")


if __name__ == "__main__":
    main(*sys.argv[1:])

#!/usr/bin/env python3
"""Writes the figures of README.md and docs/measured.md from the records under benches/runs/, so that no figure is chosen
by hand. Also writes benches/figures.md: every figure of README.md with its record, the hash of the record's sources and
the command that measures it again.

    .venv/bin/python scripts/records/front_page.py           rewrites those parts
    .venv/bin/python scripts/records/front_page.py --check   status 1 if a page differs

The kinds of records are `cycle`, `peers`, `by-hand`, `settling` and `verify`.
"""

import functools
import hashlib
import json
import sys

from record_peers import by_solver, significant, time_at
from records import link, load, the, table, write_blocks
from sources import about

MODES = [6, 20, 40, 160, 640]
SCENES = {
    "load-0.05": "rattle, 5 % load",
    "load-0.3": "rattle, 30 % load",
    "constant-contact": "constant contact",
}
# Error in half gaps after five cycles, at which solvers are compared.
TARGET = 1e-9


# A figure of README.md: kind of record, figure and its text.
Figure = tuple[str, str, str]


def microseconds(ns: float) -> str:
    return f"{significant(ns / 1e3)} µs"


def power(value: float) -> str:
    digits, exponent = f"{value:.1e}".split("e")
    return f"{digits}e{int(exponent)}"


def cycles() -> list[str]:
    """The cost of a cycle over the number of modes, and additional costs."""
    record = load("cycle", "raw.json")
    facts = record["facts"]
    ns = lambda name: record["estimates"][name]["median"]  # noqa: E731

    def cell(scene: str, n: int) -> str:
        time = ns(f"cycle/{scene}/{n}")
        real = facts["work"][f"cycle/{scene}/{n}"]["period_ns"] / time
        return microseconds(time) + (f" ({real:.0f} × real time)" if n == 40 else "")

    lines = ["| one cycle | " + " | ".join(f"{n} modes" for n in MODES) + " |"]
    lines += ["|---" * (1 + len(MODES)) + "|"]
    for scene, label in SCENES.items():
        lines.append(f"| {label} | " + " | ".join(cell(scene, n) for n in MODES) + " |")
    base = ns("cycle/load-0.05/40")
    best = ns(f"set/{facts['instructions']}/load-0.05")
    others = [
        f"{ns(f'set/{kind}/load-0.05') / best:.1f} times as long with {name}"
        for kind, name in {"avx2": "AVX2", "baseline": "the instruction set of every x86-64 processor"}.items()
        if kind != facts["instructions"]
    ]
    return [
        f"The table has medians of one run on one core ({record['cpu']}, {facts['instructions']}, shared; "
        f"{link('cycle', text='kernels')}). Compare ratios only. A mesh cycle of the default drive at "
        f"1200 rad/s lasts {facts['work']['cycle/load-0.05/40']['period_ns'] / 1e3:.0f} µs.",
        "",
        *lines,
        "",
        f"At 40 modes and 5 % load the set-up of a point takes {microseconds(ns('set-up/tables/40'))}, and a "
        f"tangent vector adds {microseconds(ns('tangents/1/40') - base)} to a cycle. "
        f"A cycle takes {' and '.join(others)}. With the mesh computed from the gears and with friction, a cycle "
        f"takes {microseconds(ns('cycle/computed/course'))} along its schedule and "
        f"{microseconds(ns('cycle/computed/60'))} in sixty segments.",
    ]


def worst_cycle() -> dict:
    """The largest error of single cycles of `volterra`."""
    lines = [
        line
        for check in load("verify", "verify.json")["checks"]
        if check["check"] == "cycle"
        for line in check["lines"]
        if line["what"].startswith("volterra") and line["unit"] == "half gaps"
    ]
    return max(lines, key=lambda line: line["value"])


def accuracy() -> str:
    worst = worst_cycle()
    return (
        f"A single cycle of `volterra` on any instruction set differs from an integrator of 30 digits by at most "
        f"{power(worst['value'])} half gaps ({worst['what'].split(': ', 1)[1]}; {link('verify', 'verify.json', '`atlas verify`')})."
    )


def solver_ratios() -> dict[str, float]:
    """Times of general-purpose solvers divided by that of `volterra` at equal error."""
    found = by_solver(load("peers", "raw.json"), "40 modes")
    base = time_at(found["volterra"], TARGET)
    times = {
        name: time_at(samples, TARGET)
        for name, samples in found.items()
        if samples and name not in ("volterra", "stepping", "reference")
    }
    return {name: time / base for name, time in times.items() if time is not None}


def solvers() -> list[str]:
    """General-purpose solvers at equal error."""
    ratios = solver_ratios()
    return [
        "General-purpose solvers have the same right-hand side of O(N) work and are restarted at every event. "
        "The table has their time divided by that of `volterra` at equal error: 1e-9 half gaps after five "
        f"rattling cycles with 40 modes ({link('peers', text='work and precision')}).",
        "",
        *table(ratios, [map(significant, ratios.values())])[:-1],
    ]


def by_hand() -> list[str]:
    """Comparison with a program for one drive."""
    cases = load("by-hand", "raw.json")["cases"]
    kinds = ("bare", "tangent")
    instructions = {"avx512": "AVX-512", "avx2": "AVX2"}[cases[0]["instructions"]]
    peer = [[case["peer"][kind][1] for kind in kinds] for case in cases]
    lines = [
        "A program in C, written by hand for this drive with mirrored flanks only, computes the same motion "
        f"({link('by-hand', text='by hand')}). It does not prove that it misses no event. The table has its time "
        f"without / with a tangent, and the times of the kernels divided by it, with {instructions} instructions:",
        "",
        "| one cycle | " + " | ".join(f"{case['modes']} modes" for case in cases) + " |",
        "|---" * (1 + len(cases)) + "|",
        "| in C, by hand | " + " | ".join(" / ".join(significant(1e6 * t) for t in own) + " µs" for own in peer) + " |",
    ]
    for name in ("closed_modes", "volterra"):
        times = [[case[name][kind][1] / t for kind, t in zip(kinds, own)] for case, own in zip(cases, peer)]
        lines.append(f"| `{name}` | " + " | ".join(" / ".join(map(significant, own)) for own in times) + " |")
    return lines


def campaign() -> list[str]:
    """flex80 as a whole."""
    r = load("settling", "record.json")
    seconds, runs, others = r["seconds"], r["runs"], r["against_verified"]
    verified, long = runs["verified"], others["integrated"]
    cells = lambda name: [  # noqa: E731
        name, f"{seconds[name]:.0f} s", f"{runs[name]['cycles'] / 1e6:.2f} million", runs[name]["chaotic"], runs[name]["not_ok"],
        f"± {runs[name]['lambda_stderr']:.3f}",
    ]  # fmt: skip
    return [
        f"`manifests/flex80.toml` has {verified['points']} points with 40 modes, without truncation. The table has the processor time of one "
        f"thread ({link('settling')}). A *survey* leaves the errors unverified. *Integrated*: `run.settle = false`, transients of 6000 cycles.",
        "",
        *table(["run", "processor time", "mesh cycles", "chaotic points", "points not `ok`", "largest error of a chaotic λ"], map(cells, runs)),
        f"The largest energy residual is {power(verified['energy_residual'])}, and {verified['twins_disagree']} twins disagree. Integrated to the "
        f"end, {long['same_class']} of {verified['points']} points have the same class and period. λ of points that settle in both differs by at "
        f"most {power(long['settled_lambda'])} per cycle, and λ of points chaotic in both by at most {significant(long['chaotic_in_errors'])} "
        "standard errors.",
    ]


def front() -> list[str]:
    """The part of README.md about speed and accuracy."""
    error, least, seconds = (figures()[place][2] for place in (0, 1, 2))
    return [
        f"The largest error of one cycle is {error} half gaps against an integrator with 30 digits "
        f"({link('verify', 'verify.json', '`atlas verify`')}). General-purpose solvers of equal error take {least} times as long or more "
        f"({link('peers', text='work and precision')}, [all figures](docs/measured.md)).",
        "",
        *by_hand(),
        "",
        f"Verified error bars of chaotic points need many cycles. `manifests/flex80.toml` takes {figures()[3][2]} mesh cycles, {seconds} of one "
        f'core. `lyapunov.effort = "survey"` takes {figures()[4][2]} and leaves the errors unverified ({link("settling", text="settling")}, '
        "[comparison](docs/estimators.md#verified-against-survey)).",
    ]


@functools.cache
def figures() -> list[Figure]:
    """Figures of README.md."""
    r = load("settling", "record.json")
    listed = [
        ("verify", "largest error of one cycle [half gaps]", power(worst_cycle()["value"])),
        ("peers", "least time of a general-purpose solver over that of `volterra`", significant(min(solver_ratios().values()))),
        ("settling", "flex80 verified, processor time", f"{r['seconds']['verified']:.0f} s"),
        ("settling", "flex80 verified, mesh cycles", f"{r['runs']['verified']['cycles'] / 1e6:.1f} million"),
        ("settling", "flex80 as a survey, processor time", f"{r['seconds']['survey']:.0f} s"),
    ]
    heads, _, *rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in by_hand() if line.startswith("|")]
    return listed + [("by-hand", f"{row[0]}, {head}", cell) for row in rows for head, cell in zip(heads[1:], row[1:])]


def list_of_figures() -> list[str]:
    """benches/figures.md: where each figure of README.md comes from."""
    rows = []
    for kind, what, text in figures():
        said = about(the(kind))
        total = hashlib.sha256(json.dumps(said.get("sources"), sort_keys=True).encode()).hexdigest()[:12] if said.get("sources") else "unknown"
        rows.append((what, text, link(kind, "about.json"), total, f"`scripts/record {kind}`"))
    return table(["figure", "value", "record", "hash of its sources", "command"], rows)[:-1]


def main(arguments: list[str]) -> None:
    measured = [*cycles(), "", accuracy(), "", *solvers(), "", *by_hand(), "", *campaign()]
    write_blocks("README.md", {"speed": front}, arguments)
    write_blocks("docs/measured.md", {"measured": lambda: measured}, arguments)
    write_blocks("benches/figures.md", {"figures": list_of_figures}, arguments)


if __name__ == "__main__":
    main(sys.argv[1:])

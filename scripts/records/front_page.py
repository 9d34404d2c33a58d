#!/usr/bin/env python3
"""Writes the figures of README.md and docs/measured.md from the records under benches/runs/, so that
each of them is a record's and none is chosen by hand.

    .venv/bin/python scripts/records/front_page.py           rewrites those parts
    .venv/bin/python scripts/records/front_page.py --check   status 1 where a page says something else

There is one record of a kind: `cycle` (scripts/record bench), `peers` and `by-hand` (scripts/record peers), `settling`
(scripts/record settling) and `verify` (scripts/record verify).
"""

import json
import sys
from pathlib import Path

from record_peers import by_solver, significant, time_at

ROOT = Path(__file__).resolve().parents[2]
BEGIN, END = "<!-- written by scripts/records/front_page.py -->\n", "<!-- end of what it writes -->\n"

MODES = [6, 20, 40, 160, 640]
SCENES = {
    "load-0.05": "rattle, 5 % load",
    "load-0.3": "rattle, 30 % load",
    "constant-contact": "constant contact",
}
# Half gaps after five cycles, at which solvers are compared.
TARGET = 1e-9


def the(kind: str) -> Path:
    """The record of a kind."""
    found = sorted((ROOT / "benches/runs").glob(f"*-{kind}-*"))
    if len(found) != 1:
        sys.exit(f"benches/runs holds {len(found)} records of the kind '{kind}'; keep the newest")
    return found[0]


def load(kind: str, file: str) -> dict:
    return json.loads((the(kind) / file).read_text())


def link(text: str, kind: str, file: str) -> str:
    return f"[{text}](benches/runs/{the(kind).name}/{file})"


def microseconds(ns: float) -> str:
    return f"{significant(ns / 1e3)} µs"


def power(value: float) -> str:
    digits, exponent = f"{value:.1e}".split("e")
    return f"{digits}e{int(exponent)}"


def cycles() -> list[str]:
    """The cycle's cost over modes, and what comes on top."""
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
        f"{link('kernels', 'cycle', 'summary.md')}). Compare ratios only. A mesh cycle of the default drive at "
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


def accuracy() -> str:
    """The largest error of single cycles."""
    checks = load("verify", "verify.json")["checks"]
    lines = [
        line
        for check in checks
        if check["check"] == "cycle"
        for line in check["lines"]
        if line["what"].startswith("volterra") and line["unit"] == "half gaps"
    ]
    worst = max(lines, key=lambda line: line["value"])
    return (
        f"A single cycle of `volterra` on any instruction set differs from an integrator of 30 digits by at most "
        f"{power(worst['value'])} half gaps ({worst['what'].split(': ', 1)[1]}; "
        f"{link('`atlas verify`', 'verify', 'verify.json')})."
    )


def solvers() -> list[str]:
    """General-purpose solvers at equal error."""
    record = load("peers", "raw.json")
    found = by_solver(record, "40 modes")
    base = time_at(found["volterra"], TARGET)
    ratios = {
        name: time_at(samples, TARGET)
        for name, samples in found.items()
        if samples and name not in ("volterra", "stepping", "reference")
    }
    heads = [name for name, time in ratios.items() if time is not None]
    return [
        "General-purpose solvers have the same right-hand side of O(N) work and are restarted at every event. "
        "The table has their time divided by that of `volterra` at equal error: 1e-9 half gaps after five "
        f"rattling cycles with 40 modes ({link('work and precision', 'peers', 'summary.md')}).",
        "",
        "| " + " | ".join(heads) + " |",
        "|---" * len(heads) + "|",
        "| " + " | ".join(significant(ratios[name] / base) for name in heads) + " |",
    ]


def by_hand() -> list[str]:
    """A program that was written for one drive."""
    cases = load("by-hand", "raw.json")["cases"]
    kinds = ("bare", "tangent")
    peer = [[case["peer"][kind][1] for kind in kinds] for case in cases]
    lines = [
        "A program in C, written by hand for this drive with mirrored flanks only, computes the same motion "
        f"({link('by hand', 'by-hand', 'summary.md')}). It does not prove that it misses no event. The table has its time "
        "without / with a tangent, and the times of the kernels divided by it:",
        "",
        "| one cycle | " + " | ".join(f"{case['modes']} modes" for case in cases) + " |",
        "|---" * (1 + len(cases)) + "|",
        "| in C, by hand | " + " | ".join(" / ".join(significant(1e6 * t) for t in own) + " µs" for own in peer) + " |",
    ]
    for name in ("closed_modes", "volterra"):
        times = [[case[name][kind][1] / t for kind, t in zip(kinds, own)] for case, own in zip(cases, peer)]
        lines.append(f"| `{name}` | " + " | ".join(" / ".join(map(significant, own)) for own in times) + " |")
    return lines


def campaign() -> str:
    """flex80 as a whole."""
    r = load("settling", "record.json")
    seconds = r["seconds"]
    return (
        f"`manifests/flex80.toml` has {r['points']} points with 40 modes, without truncation, and every chaotic λ to "
        f"± {r['lambda_stderr']:.2f}. It takes {seconds['settled']:.2f} s on one core and "
        f"{seconds['settled on 2 threads']:.2f} s on two, for {r['cycles']} cycles. The largest energy residual is "
        f"{power(r['energy_residual'])}, and {r['twins_disagree']} twins disagree. With `run.settle = false` it integrates to "
        f"the end with transients of 6000 cycles and takes "
        f"{seconds['integrated'] / seconds['settled']:.1f} times as long (settled points "
        f"{r['settled_ratio']:.1f} times). Then {r['same_class']} of {r['points']} points have the same class, and the "
        f"exponents of periodic points agree to {power(r['settled_lambda_difference'])} "
        f"({link('settling', 'settling', 'summary.md')})."
    )


def pages() -> dict[Path, list[str]]:
    """What is written, by page."""
    all_of_it = [*cycles(), "", accuracy(), "", *solvers(), "", *by_hand(), "", campaign()]
    links = [line.replace("](benches/", "](../benches/") for line in all_of_it]
    return {ROOT / "README.md": by_hand(), ROOT / "docs/measured.md": links}


def main(arguments: list[str]) -> None:
    for page, lines in pages().items():
        text = page.read_text()
        head, rest = text.split(BEGIN)
        written = head + BEGIN + "\n" + "\n".join(lines) + "\n\n" + END + rest.split(END)[1]
        if arguments != ["--check"]:
            page.write_text(written)
        elif written != text:
            sys.exit(f"the figures of {page.name} are not those of benches/runs: scripts/records/front_page.py")


if __name__ == "__main__":
    main(sys.argv[1:])

"""Writes summary.md with the times of two builds of the program for the same jobs, in turn.

    python3 scripts/records/record_before_after.py COMMIT ATLAS COMMIT ATLAS benches/runs/NAME
"""

import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

from records import keep, processor, spent

TURNS = int(os.environ.get("TURNS", "5"))
# Part of the name of the jobs to run; all jobs if it is empty.
ONLY = os.environ.get("ONLY", "")
GRID = "grid={load={values=[0.05, 0.30]},speed={values=[1200, 1500]}}"
# No search for orbits: its matrices of many modes would take most of the time.
INTEGRATED = ["-j", "1", "--set", GRID, "--set", "run.settle=false", "--set", "run.transient=200", "--set", "run.cycles=2000"]


def modes(count):
    """Arguments for a number of modes."""
    return [*INTEGRATED, "--set", f"model.modes={count}", "--set", f"model.retained={count}"]


# Helical gears in steady contact, with the stiffness from the drawing.
SPEEDS = [
    *["-j", "1", "--set", "model.modes=12", "--set", "model.retained=12", "--set", "gear.helix_angle=\"15 deg\""],
    *["--set", "mesh={half_gap=\"50 um\",stiffness=\"table\",contact_damping=0.05}"],
    *["--set", "grid={load=1,speed={from=\"500 rpm\",to=\"6000 rpm\",count=400}}", "--set", "run.transient=500"],
    *["--set", "excitation={transmission_error=[{harmonic=1,amplitude=\"1 um\"}]}"],
]


CASES = [
    ("flex80, 80 points, 40 modes, one thread", ["-j", "1"]),
    ("flex80, 80 points, 40 modes, two threads", ["-j", "2"]),
    ("4 points of 2200 cycles, 160 modes, one thread", modes(160)),
    ("4 points of 2200 cycles, 640 modes, one thread", [*modes(640), "--set", "shafts.elements=[12, 18, 24]"]),
    ("400 speeds of helical gears in steady contact, 12 modes, one thread", SPEEDS),
]


def ran(program, arguments, folder):
    """Processor time, cycles and the largest residual of a run; status 3 is a run whose points are not all ok."""
    command = [program, "run", "manifests/flex80.toml", "--quiet", "--out", folder, *arguments]
    already = spent()
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    time = spent() - already
    if done.returncode not in (0, 3):
        sys.exit(f"{' '.join(map(str, command))}: status {done.returncode}\n{done.stderr}")
    totals = json.loads((folder / "run.json").read_text())["totals"]
    shown = json.loads(subprocess.run([program, "show", folder, "--json"], capture_output=True, text=True, check=True).stdout)
    return time, totals["cycles"], shown["worst_energy"][1]


def main(before, older, after, newer, out):
    rows = []
    with tempfile.TemporaryDirectory() as work:
        for number, (name, arguments) in enumerate(case for case in CASES if ONLY in case[0]):
            found = {older: [], newer: []}
            for turn in range(TURNS):
                # The order alternates, so that a machine that warms up or slows down favours neither.
                for program in [older, newer][:: 1 if turn % 2 else -1]:
                    folder = pathlib.Path(work) / f"{number}-{turn}-{program == newer}"
                    found[program].append(ran(program, arguments, folder))
            times = {program: [run[0] for run in runs] for program, runs in found.items()}
            ratios = [a / b for a, b in zip(times[older], times[newer])]
            cells = [name]
            for program in (older, newer):
                _, cycles, residual = found[program][-1]
                cells += [f"{statistics.median(times[program]):.2f}", str(cycles), f"{residual:.1e}"]
            cells.append(f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})")
            rows.append("| " + " | ".join(cells) + " |")
            print(rows[-1], flush=True)
    head = ["job", f"{before} [s]", "cycles", "residual", f"{after} [s]", "cycles", "residual", "before / after"]
    text = [
        f"# {before} and {after}, in turn\n",
        f"{processor()}, {os.cpu_count()} processors, `scripts/record before-after {before}`: `manifests/flex80.toml`, processor time "
        f"(user and system), medians of {TURNS} turns; the ratio is the median of the turns' own, with the smallest and the largest. Residual: "
        f"the largest of the energy balance over all points. {os.getloadavg()[2]:.1f} runnable tasks at the end.\n",
        "| " + " | ".join(head) + " |",
        "|" + "---|" * len(head),
        *rows,
    ]
    keep(out, text)


if __name__ == "__main__":
    main(*sys.argv[1:])

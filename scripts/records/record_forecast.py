"""Writes summary.md with forecasts and the times of the runs.

    python3 scripts/records/record_forecast.py benches/runs/NAME
"""

import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

from records import ATLAS, keep

# Manifests of every kind that are small enough for three runs: grids, chains, tables, many modes.
MANIFESTS = [
    "quickstart", "points", "modes", "modes-mta", "flex80", "flex80-table", "pairs", "misalignment",
    "speed-sweep", "unsettled",
]
TURNS = int(os.environ.get("TURNS", "3"))
WANTED = 0.15


def atlas(program, *arguments, well=(0,)):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode not in well:
        sys.exit(f"atlas {' '.join(map(str, arguments))}: status {done.returncode}\n{done.stderr}")
    return done.stdout


def main(out):
    program = ATLAS
    rows, close, within = [], 0, 0
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        machine = work / "machine"
        atlas(program, "machine", "--quick", "--quiet", "--out", machine)
        for name in MANIFESTS:
            manifest = f"manifests/{name}.toml"
            forecasts, taken = [], []
            # In turn, so that both run on the machine in the same state.
            for turn in range(TURNS):
                plan = json.loads(atlas(program, "plan", manifest, "--json", "--machine", machine, "--on", machine))
                forecasts.append(plan["elsewhere"][1])
                folder = work / f"{name}-{turn}"
                # Status 3: complete, but some points have another status than ok.
                atlas(program, "run", manifest, "--out", folder, well=(0, 3))
                run = json.loads((folder / "run.json").read_text())
                taken.append(run["totals"]["wall_time"])
            expected = statistics.median(f["expected"] for f in forecasts)
            low = statistics.median(f["low"] for f in forecasts)
            high = statistics.median(f["high"] for f in forecasts)
            time = statistics.median(taken)
            ratio = expected / time
            close += abs(ratio - 1) <= WANTED
            within += low <= time <= high
            spread = (max(taken) - min(taken)) / time
            rows.append((name, plan["points"], plan["calibrated"], f"{expected:.2f}", f"{low:.2f} to {high:.2f}",
                f"{time:.2f}", f"{ratio:.2f}", f"{100 * spread:.0f} %"))
            print(*rows[-1], flush=True)
        found = json.loads((machine / "machine.json").read_text())
    head = ("manifest", "points", "tried out", "forecast [s]", "interval [s]", "took [s]", "forecast / took",
        "spread of runs")
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(map(str, row)) + " |" for row in rows]
    load = os.getloadavg()[2]
    text = [
        "# What `atlas plan --on` forecasts beside what runs take\n",
        f"{found['description']['cpu']}, {found['description']['cores']} cores, {found['started']}, "
        f"{found['program']['version']} ({found['program']['commit']}), `scripts/record forecast`. The machine of "
        "`--on` is this one. Medians of three turns, forecast and run in turn.",
        "Quiet." if found["noise"]["quiet"] else "**Not quiet**: " + "; ".join(found["noise"]["remarks"]) +
        f"; {load:.1f} runnable tasks on {found['description']['threads']} threads at the end.",
        "",
        *lines,
        f"\n{close} of {len(rows)} within {100 * WANTED:.0f} % (wanted: 9 of 10); {within} of {len(rows)} took a "
        "time within the interval stated.",
    ]
    keep(out, text)


if __name__ == "__main__":
    main(*sys.argv[1:])

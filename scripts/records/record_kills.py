"""Kills commands at random moments, starts them again, compares bits, and writes summary.md.

    .venv/bin/python scripts/records/record_kills.py benches/runs/NAME [KILLS]
"""

import json
import pathlib
import random
import subprocess
import sys
import tempfile
import time

import polars as pl
from records import ATLAS, ROOT, keep, processor

KILLS = 1000
SEED = 1
# Largest moment of a kill, as a part of the time of an undisturbed command: commands that begin anew also come to an end.
MARGIN = 1.3
# Columns about the place and time of a computation, not its results.
PLACEMENT = ["wall_time", "worker", "numa_node"]
# Files with a time.
DATED = ("report.html", "export.json", "follow.json", "runup.json", "trace.json", "run.json")

OSCILLATOR = (ROOT / "tests/data/oscillator.toml").read_text()
POINTS = OSCILLATOR.replace("count = 3", "count = 24").replace("cycles = 300", "cycles = 600")
CHAINS = POINTS.replace("count = 24 }", 'count = 24 }\norder = "both"')
REFINED = POINTS.replace("count = 24 }", "count = 3 }\nrefine = { levels = 3 }").replace("count = 2 }", "count = 3 }")
ORBITS = OSCILLATOR + '\n[continuation]\nover = "speed"\nstarts = 6\nlongest_period = 2\n'
RUN_UP = OSCILLATOR + '\n[runup]\nspeed = { from = 600, to = 1500, in = "2 s" }\n'
MANIFESTS = {"points": POINTS, "chains": CHAINS, "refined": REFINED, "orbits": ORBITS, "run-up": RUN_UP}
assert len(set(MANIFESTS.values())) == len(MANIFESTS)

# Each job: its command without the folder of its results.
JOBS = {
    "run, points": ["run", "points.toml", "--quiet"],
    "run, chains": ["run", "chains.toml", "--quiet"],
    "run, refined grid": ["run", "refined.toml", "--quiet"],
    "follow": ["follow", "orbits.toml", "--quiet"],
    "runup": ["runup", "run-up.toml", "--overwrite"],
    "trace": ["trace", "points.toml", "--point", "3", "--cycles", "4000", "--overwrite"],
    "export": ["export", "whole-run, points", "--overwrite"],
}


def start(work, job, out, threads):
    command = [ATLAS, *JOBS[job], "--out", out]
    if job != "export":
        command += ["--threads", str(threads)]
    return subprocess.Popen(command, cwd=work, stdout=subprocess.DEVNULL)


def contents(folder):
    """Every visible file: tables without their placement columns, others as bytes; records of a time only by name."""
    found = {}
    for path in sorted(folder.iterdir()) if folder.exists() else []:
        if path.name.startswith("."):
            continue
        if path.suffix == ".parquet":
            table = pl.read_parquet(path)
            found[path.name] = table.drop([c for c in PLACEMENT if c in table.columns])
        else:
            found[path.name] = None if path.name in DATED else path.read_bytes()
    return found


def equal(a, b):
    return a.equals(b) if isinstance(a, pl.DataFrame) else a == b


def same(a, b):
    return a.keys() == b.keys() and all(equal(a[name], b[name]) for name in a)


def broken(whole, folder):
    """Visible files of a killed command that differ from those of one that ended."""
    return [name for name, own in contents(folder).items() if name not in whole or not equal(own, whole[name])]


def stage(job, folder):
    """What a killed command has left."""
    if not folder.exists():
        return "nothing"
    if any(not path.name.startswith(".") for path in folder.iterdir()):
        return "results, some or all"
    journal = folder / ".journal"
    return "points in the journal" if journal.exists() and journal.stat().st_size > 400 else "hidden files"


def main(folder, kills):
    chance = random.Random(SEED)
    log, rounds = [], []
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        (work / "oscillator.modal.toml").write_bytes((ROOT / "tests/data/oscillator.modal.toml").read_bytes())
        for name, text in MANIFESTS.items():
            (work / f"{name}.toml").write_text(text)
        whole, patience = {}, {}
        for job in JOBS:
            clock = time.perf_counter()
            assert start(work, job, f"whole-{job}", 2).wait() in (0, 3), job
            patience[job] = time.perf_counter() - clock
            whole[job] = contents(work / f"whole-{job}")
        while len(log) < kills:
            job = list(JOBS)[len(rounds) % len(JOBS)]
            out, own, wrong = work / f"round-{len(rounds)}", 0, []
            while True:
                run = start(work, job, out.name, chance.choice([1, 2]))
                moment = chance.uniform(0, MARGIN * patience[job])
                try:
                    # After the requested number of kills the command continues to its end.
                    code = run.wait(timeout=moment if len(log) < kills else None)
                    assert code in (0, 3), (job, code)
                    break
                except subprocess.TimeoutExpired:
                    run.kill()
                    run.wait()
                    own += 1
                    wrong += broken(whole[job], out)
                    log.append({"job": job, "moment": moment, "stage": stage(job, out)})
            record = out / "run.json"
            resumed = json.loads(record.read_text())["totals"]["resumed"] if record.exists() else 0
            rounds.append(
                {
                    "job": job,
                    "kills": own,
                    "resumed": resumed,
                    "same": same(whole[job], contents(out)),
                    "broken": wrong,
                    "left": sorted(p.name for p in [*work.iterdir(), *out.iterdir()] if p.name.startswith(".")),
                }
            )
    counts = {}
    for kill in log:
        counts.setdefault(kill["job"], {}).setdefault(kill["stage"], []).append(kill)
    stages = sorted({kill["stage"] for kill in log})
    rows = [
        ("kills", len(log)),
        ("commands brought to an end", len(rounds)),
        ("kills survived by one command, most", max(r["kills"] for r in rounds)),
        ("points taken over, sum over the last starts", sum(r["resumed"] for r in rounds)),
        ("visible files of killed commands with other contents", sum(len(r["broken"]) for r in rounds)),
        ("commands that ended with other bits", sum(not r["same"] for r in rounds)),
        ("commands that left hidden files", sum(bool(r["left"]) for r in rounds)),
    ]
    lines = [
        "# Commands killed at random moments and started again",
        "",
        f"{processor()}; in turn the commands below, on drives of one mode; SIGKILL at a moment drawn evenly from",
        f"{MARGIN} times the time of an undisturbed command; 1 or 2 threads by lot. After each kill, files that users see are compared with those of an",
        "undisturbed command, and again after the end.",
        "",
        "| | |",
        "|---|---|",
        *(f"| {name} | {value} |" for name, value in rows),
        "",
        f"| kills by what they left | {' | '.join(stages)} |",
        f"|---|{'---|' * len(stages)}",
        *(f"| {job} | {' | '.join(str(len(of.get(own, []))) for own in stages)} |" for job, of in counts.items()),
        "",
    ]
    keep(folder, lines, kills={"kills": log, "runs": rounds})
    return any(not r["same"] or r["left"] or r["broken"] for r in rounds)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else KILLS))

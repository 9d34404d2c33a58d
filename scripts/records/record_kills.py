"""Kills runs at random times, resumes them, compares bits, and writes summary.md.

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

KILLS = 200
SEED = 1
# Columns about the place and time of a computation, not its results.
PLACEMENT = ["wall_time", "worker", "numa_node"]


def manifests():
    """Independent points, and chains in which each point starts from the state of the last one."""
    text = (ROOT / "tests/data/oscillator.toml").read_text()
    text = text.replace("count = 3", "count = 24").replace("cycles = 300", "cycles = 600")
    swept = text.replace("count = 24 }", 'count = 24 }\norder = "both"')
    assert swept != text
    return {"points": text, "chains": swept}


def start(work, name, out, threads):
    return subprocess.Popen(
        [ATLAS, "run", f"{name}.toml", "--out", out, "--quiet", "--threads", str(threads)],
        cwd=work,
    )


def tables(folder):
    """Every table without its placement columns."""
    found = {}
    for path in sorted(folder.glob("*.parquet")):
        table = pl.read_parquet(path)
        found[path.name] = table.drop([c for c in PLACEMENT if c in table.columns])
    return found


def same(a, b):
    return a.keys() == b.keys() and all(a[name].equals(b[name]) for name in a)


def stage(folder):
    """The stage of a killed run."""
    if (folder / "run.json").exists():
        return "record written"
    if any(folder.glob("*.parquet")):
        return "tables being published"
    journal = folder / ".journal"
    if not journal.exists():
        return "before the journal"
    return "points in the journal" if journal.stat().st_size > 400 else "journal begun"


def main(folder, kills):
    chance = random.Random(SEED)
    log, rounds = [], []
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        (work / "oscillator.modal.toml").write_bytes(
            (ROOT / "tests/data/oscillator.modal.toml").read_bytes()
        )
        whole, patience = {}, {}
        for name, text in manifests().items():
            (work / f"{name}.toml").write_text(text)
            clock = time.perf_counter()
            assert start(work, name, f"whole-{name}", 2).wait() in (0, 3)
            patience[name] = time.perf_counter() - clock
            whole[name] = tables(work / f"whole-{name}")
        while len(log) < kills:
            name = ["points", "chains"][len(rounds) % 2]
            out, own = work / f"round-{len(rounds)}", 0
            while True:
                run = start(work, name, out.name, chance.choice([1, 2]))
                moment = chance.uniform(0, patience[name])
                try:
                    # After the requested number of kills the run continues to its end.
                    code = run.wait(timeout=moment if len(log) < kills else None)
                    assert code in (0, 3), code
                    break
                except subprocess.TimeoutExpired:
                    run.kill()
                    run.wait()
                    own += 1
                    log.append({"job": name, "moment": moment, "stage": stage(out)})
            record = json.loads((out / "run.json").read_text())
            rounds.append(
                {
                    "job": name,
                    "kills": own,
                    "resumed": record["totals"]["resumed"],
                    "same": same(whole[name], tables(out)),
                    "left": sorted(p.name for p in out.iterdir() if p.name.startswith(".")),
                }
            )
    stages = {}
    for kill in log:
        stages[kill["stage"]] = stages.get(kill["stage"], 0) + 1
    rows = [
        ("kills", len(log)),
        *((f"of these, {name}", count) for name, count in sorted(stages.items())),
        ("runs brought to an end", len(rounds)),
        ("kills survived by one run, most", max(r["kills"] for r in rounds)),
        ("points taken over, sum over the last starts", sum(r["resumed"] for r in rounds)),
        ("runs that ended with other bits", sum(not r["same"] for r in rounds)),
        ("runs that left hidden files", sum(bool(r["left"]) for r in rounds)),
    ]
    lines = [
        "# Runs killed at random moments and taken up again",
        "",
        f"{processor()}; 48 independent points, and 4 chains of 24 points, in turn; SIGKILL at a",
        "moment drawn evenly from the time of an undisturbed run; 1 or 2 threads by lot.",
        "",
        "| | |",
        "|---|---|",
        *(f"| {name} | {value} |" for name, value in rows),
        "",
    ]
    keep(folder, lines, kills={"kills": log, "runs": rounds})
    return any(not r["same"] or r["left"] for r in rounds)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else KILLS))

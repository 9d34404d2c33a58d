"""What does a plane of an oscillator with one mode cost beside a loop in C that was written for it?

    .venv/bin/python scripts/records/record_one_mode.py benches/runs/NAME [TURNS]

manifests/oscillators/one-sided-stop.toml with 100 gaps and 100 stiffnesses, and one exponent, on one thread.
"""

import pathlib
import statistics
import sys
import tempfile

import polars as pl
from records import ATLAS, ROOT, keep, output, processor_time, table, this_run

SIDE = 100
PEER = "target/by-hand/one_mode 100 -0.2 0.2 100 10 100 2.8 0.1 1 1 500 2000".split()
SETTINGS = {
    "grid": "{ speed = 2.8, "
    f'"contact.stop.gap" = {{ from = -0.2, to = 0.2, count = {SIDE} }}, '
    f'"contact.stop.stiffness" = {{ from = 10.0, to = 100.0, count = {SIDE}, spacing = "log" }} }}',
    "analyses.lyapunov.exponents": "1",
}
LEAST_AGREEMENT = 0.95


def main(folder: str, turns: str = "5") -> None:
    manifest = ROOT / "manifests/oscillators/one-sided-stop.toml"
    changes = [argument for key, value in SETTINGS.items() for argument in ("--set", f"{key}={value}")]
    times: dict[str, list[float]] = {"peer": [], "atlas": []}
    with tempfile.TemporaryDirectory() as work:
        out = pathlib.Path(work) / "out"
        command = [ATLAS, "run", manifest, "--out", out, "--tables", work, "--quiet", "--overwrite", "--threads", "1", *changes]
        for _ in range(int(turns)):
            lines = pathlib.Path(work) / "peer"
            with lines.open("w") as file:
                times["peer"].append(processor_time(PEER, stdout=file))
            times["atlas"].append(processor_time(command))
        points = pl.read_parquet(out / "points.parquet").sort("contact.stop.gap", "contact.stop.stiffness")
        peer = pl.read_csv(lines, separator=" ", has_header=False, new_columns=["period", "lambda", "cycles", "events"])
    settled = (peer["period"] > 0) & (points["class"] == "periodic")
    same = float((peer["period"] == points["period"]).filter(settled).mean())
    if same < LEAST_AGREEMENT:
        sys.exit(f"record_one_mode: only {same:.1%} of the points that both find periodic have the same period")
    seconds = {name: statistics.median(own) for name, own in times.items()}
    cycles = {"peer": int(peer["cycles"].sum()), "atlas": int(points["cycles"].sum())}
    record = {"command": "scripts/record one-mode", **this_run(), "seconds": seconds, "turns": times, "cycles": cycles, "same_period": same}
    count = SIDE * SIDE
    lines = [
        f"# {pathlib.Path(folder).name}",
        "",
        f"`scripts/record one-mode` on {record['cpu']}, {record['cores']} cores, load average {record['load']} at the end;",
        f"commit {record['commit'][:8]}, {output('cc', '--version').splitlines()[0]}.",
        "",
        f"The plane of `manifests/oscillators/one-sided-stop.toml` with {count} points and the largest exponent, on one thread. The peer",
        "is `benches/peers/by_hand/one_mode.c`. Both stop at a point when its motion repeats, the peer after 1 to 16 cycles.",
        f"Medians of processor time over {turns} runs in turn, start and output included.",
        "",
        *table(
            ["", "peer", "atlas", "ratio"],
            [
                ["µs per point", *(f"{1e6 * own / count:.0f}" for own in seconds.values()), f"{seconds['atlas'] / seconds['peer']:.2f}"],
                ["mesh cycles per point", *(f"{own / count:.0f}" for own in cycles.values()), ""],
                ["ns per cycle", *(f"{1e9 * seconds[name] / cycles[name]:.0f}" for name in seconds), ""],
            ],
        ),
        f"{same:.2%} of the points that both find periodic have the same period. The peer proves neither events nor periods, has no",
        "error bars, and writes no tables.",
        "",
    ]
    keep(folder, lines, record=record)


if __name__ == "__main__":
    main(*sys.argv[1:])

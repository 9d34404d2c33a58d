"""Ctrl-C in a run of the Python package: it ends at once, and the same call or the command line goes on.

The interrupted runs are processes of their own, which a real SIGINT meets."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import gearatlas
from program import ATLAS, ROOT, same_bits

SCRIPT = """
import sys, time, gearatlas
manifest, out, tables = sys.argv[1:]
try:
    gearatlas.run(manifest, out, tables=tables, threads=2, progress=False)
except KeyboardInterrupt:
    print(time.monotonic())
    raise
"""

MAPPING = """
import sys, time, numpy, gearatlas
map = gearatlas.CycleMap(gearatlas.load(sys.argv[1]).point())
states = numpy.tile(map.start(), (1000, 1))
try:
    print("ready", flush=True)
    map(states, 10_000_000)
except KeyboardInterrupt:
    print(time.monotonic())
    raise
"""


@pytest.fixture(scope="module")
def manifest(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("job")
    text = (ROOT / "tests/data/oscillator.toml").read_text()
    changed = {
        "count = 2": "count = 8",
        "count = 3": "count = 8",
        "cycles = 300": "cycles = 4000\nsettle = false",
        'file = "oscillator': f'file = "{ROOT}/tests/data/oscillator',
    }
    for old, new in changed.items():
        assert old in text
        text = text.replace(old, new)
    (folder / "m.toml").write_text(text)
    return folder / "m.toml"


@pytest.fixture(scope="module")
def undisturbed(manifest, tmp_path_factory) -> gearatlas.Results:
    return gearatlas.run(manifest, tmp_path_factory.mktemp("undisturbed") / "run", progress=False)


def interrupted(script: str, arguments: list[object], is_under_way) -> float:
    """Runs a script, sends it SIGINT once something is under way, and says how long it took to end [s]."""
    command = [sys.executable, "-c", script, *map(str, arguments)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        patience = time.monotonic() + 60
        while not is_under_way(process):
            assert process.poll() is None and time.monotonic() < patience, process.stderr.read()
            time.sleep(0.01)
        sent = time.monotonic()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode in (1, -signal.SIGINT, 130) and "KeyboardInterrupt" in err, err
    return float(out.split()[-1]) - sent


def interrupt_run(manifest: Path, out: Path, tables: Path) -> float:
    journal = out / ".journal"

    def under_way(_: subprocess.Popen) -> bool:
        # Beyond its head, some points.
        return journal.exists() and journal.stat().st_size > 4000

    return interrupted(SCRIPT, [manifest, out, tables], under_way)


def same(one: gearatlas.Results, other: gearatlas.Results) -> None:
    for name in other.tables:
        same_bits(one.table(name).to_pyarrow(), other.table(name).to_pyarrow())


@pytest.mark.parametrize("by", ["the same call", "the command line"])
def test_an_interrupted_run_is_taken_up(by, manifest, undisturbed, tmp_path, record_property):
    out = tmp_path / "run"
    seconds = interrupt_run(manifest, out, tmp_path)
    print(f"KeyboardInterrupt {1e3 * seconds:.0f} ms after SIGINT")
    record_property("seconds_to_end", seconds)
    assert (out / ".journal").exists()
    partial = gearatlas.open(out)
    assert partial.record["state"] == "interrupted" and 0 < partial.points.rows < 64
    if by == "the same call":
        told: list[gearatlas.Progress] = []
        results = gearatlas.run(manifest, out, tables=tmp_path, progress=told.append)
        assert told[0].resumed > 0
    else:
        subprocess.run([ATLAS, "run", manifest, "--out", out, "--quiet"], check=True, cwd=tmp_path)
        results = gearatlas.open(out)
    assert results.record["totals"]["resumed"] >= partial.points.rows > 0
    assert not (out / ".journal").exists()
    same(results, undisturbed)


def test_a_map_is_interrupted():
    seconds = interrupted(
        MAPPING, [ROOT / "manifests/quickstart.toml"], lambda process: process.stdout.readline() != ""
    )
    print(f"KeyboardInterrupt {1e3 * seconds:.0f} ms after SIGINT")


def test_other_threads_run_while_a_run_computes(manifest, tmp_path):
    """The lock of the interpreter is released: another thread counts on."""
    import threading

    counted, stop = [0], threading.Event()

    def count() -> None:
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    try:
        gearatlas.run(manifest, tmp_path / "run", threads=1, progress=False)
    finally:
        stop.set()
        thread.join()
    assert counted[0] > 20

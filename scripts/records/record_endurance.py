"""Does the program survive long runs, and runs that the system disturbs? Counts every deviation as a fault.

    .venv/bin/python scripts/records/record_endurance.py benches/runs/NAME [PART…]
"""

import contextlib
import json
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import threading
import time

import polars as pl
from records import ATLAS, ROOT, keep

# Columns about the place and time of a computation, not its results.
PLACEMENT = ["wall_time", "worker", "numa_node"]

OSCILLATOR = (ROOT / "tests/data/oscillator.toml").read_text()


class Place:
    """A folder with a manifest."""

    def __init__(self, folder, manifest):
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / "m.toml").write_text(manifest)
        shutil.copy(ROOT / "tests/data/oscillator.modal.toml", self.folder)

    def start(self, out, *arguments, before=(), **environment):
        command = [*before, ATLAS, "run", "m.toml", "--out", out, *arguments]
        return subprocess.Popen(
            command,
            cwd=self.folder,
            env=os.environ | environment,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )

    def run(self, out, *arguments, **options):
        """Exit status, errors, peak memory [MB]."""
        process = self.start(out, "--quiet", *arguments, **options)
        peak = peak_of(process)
        _, said = process.communicate()
        return process.returncode, said, peak

    def record(self, out):
        return json.loads((self.folder / out / "run.json").read_text())

    def tables(self, out):
        found = {}
        for path in sorted((self.folder / out).glob("*.parquet")):
            table = pl.read_parquet(path)
            found[path.name] = table.drop([c for c in PLACEMENT if c in table.columns])
        return found


def peak_of(process):
    """Peak memory of a process [MB], read every hundredth of a second. The system's figure for a process that has ended
    includes that of its parent."""
    status, peak = pathlib.Path(f"/proc/{process.pid}/status"), 0.0
    while process.poll() is None:
        with contextlib.suppress(OSError):
            lines = dict(line.split(":", 1) for line in status.read_text().splitlines())
            peak = max(peak, float(lines.get("VmHWM", "0 kB").split()[0]) / 1024)
        time.sleep(0.01)
    return peak


def same(a, b):
    return a.keys() == b.keys() and all(a[name].equals(b[name]) for name in a)


def one_point(cycles):
    """A chaotic point, integrated to the end."""
    text = OSCILLATOR.replace("load = { from = 0.05, to = 0.3, count = 2 }", "load = 0.05")
    text = text.replace("speed = { from = 600, to = 1500, count = 3 }", "speed = 900")
    text = text.replace("cycles = 300", f"cycles = {cycles}\nsettle = false")
    return text.replace("damping = 0.05", "damping = 0.02")


def grid(loads, speeds, cycles):
    text = OSCILLATOR.replace("to = 0.3, count = 2", f"to = 0.3, count = {loads}")
    text = text.replace("to = 1500, count = 3", f"to = 1500, count = {speeds}")
    text = text.replace("transient = 50", "transient = 10").replace("cycles = 300", f"cycles = {cycles}")
    for analysis in ["poincare = { samples = 20 }\n", ", spectrum = {}"]:
        assert analysis in text
        text = text.replace(analysis, "")
    return text


def part_cycles(work, note):
    peaks = []
    for cycles in [10**5, 10**6, 10**7]:
        place = Place(work / f"cycles-{cycles}", one_point(cycles))
        begun = time.monotonic()
        status, said, peak = place.run("r", "--threads", "1")
        row = place.tables("r")["points.parquet"].row(0, named=True)
        took = time.monotonic() - begun
        note(
            f"{cycles:.0e} cycles",
            f"{row['class']}, status {row['status']}, {row['cycles']} cycles in {took:.0f} s, peak {peak:.1f} MB, "
            f"λ = {row['lambda_max']:.5f} ± {row['lambda_stderr'] or 0:.1e}",
            status in (0, 3) and row["cycles"] >= cycles,
        )
        peaks.append(peak)
    note("memory over cycles", f"10⁷ take {peaks[2] / peaks[0]:.3f} of what 10⁵ take", peaks[2] < 1.1 * peaks[0] + 2)


def part_points(work, note):
    peaks = []
    for loads, speeds in [(25, 40), (100, 100), (250, 400)]:
        count = loads * speeds
        place = Place(work / f"points-{count}", grid(loads, speeds, 20))
        begun = time.monotonic()
        status, said, peak = place.run("r")
        took = time.monotonic() - begun
        table = place.tables("r")["points.parquet"]
        ids = table["point_id"]
        whole = len(table) == count and ids.equals(pl.Series("point_id", range(count), dtype=ids.dtype))
        left = [path.name for path in (place.folder / "r").iterdir() if path.name.startswith(".")]
        size = (place.folder / "r/points.parquet").stat().st_size
        note(
            f"{count} points",
            f"{took:.0f} s, peak {peak:.1f} MB, file {size / 1e6:.1f} MB",
            status in (0, 3) and whole and not left,
        )
        peaks.append(peak)
    note("memory over points", f"10⁵ take {peaks[2] / peaks[1]:.2f} of what 10⁴ take", peaks[2] < 1.5 * peaks[1])


def part_disk(work, note):
    if os.geteuid():
        return note("disk that fills", "left out: only root mounts one", True)
    place = Place(work / "disk", grid(20, 100, 100))
    place.run("whole")
    disk = place.folder / "small"
    disk.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64m", "tmpfs", disk], check=True)
    process = place.start("small/r", "--quiet")
    try:
        filler = disk / "filler"
        journal, deadline = disk / "r/.journal", time.monotonic() + 60
        while time.monotonic() < deadline and not (journal.exists() and journal.stat().st_size > 100_000):
            time.sleep(0.001)
        # Another program fills the remaining space during the run.
        with open(filler, "wb") as file:
            try:
                while True:
                    file.write(bytes(1 << 16))
                    file.flush()
            except OSError:
                pass
        _, said = process.communicate(timeout=120)
        clear = process.returncode == 1 and "is full" in said and len(said.splitlines()) == 1
        note("disk that fills", f"status {process.returncode}: {said.strip()}", clear)
        filler.unlink()
        status, said, _ = place.run("small/r")
        resumed = place.record("small/r")["totals"]["resumed"] if status in (0, 3) else 0
        equal = status in (0, 3) and same(place.tables("whole"), place.tables("small/r"))
        note("disk that is freed", f"status {status}, {resumed} points taken over, same tables: {equal}", equal and resumed > 0)
    finally:
        process.kill()
        process.wait()
        subprocess.run(["umount", disk], check=True)


def part_clocks(work, note):
    library = next(iter(pathlib.Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1")), None)
    if library is None:
        return note("clocks that jump", "left out: faketime is not installed", True)
    place = Place(work / "clocks", grid(10, 40, 400))
    place.run("whole", "--threads", "1")
    for name, jumps, monotonic in [
        ("wall clock back a day", ["+0", "-1d"], "1"),
        ("wall clock on a year", ["+0", "+365d"], "1"),
        ("wall clock to and fro", ["+0", "-1d", "+2d", "-3d", "+1d"], "1"),
        ("every clock on an hour", ["+0", "+1h"], "0"),
    ]:
        setting = place.folder / "faketime"
        setting.write_text(jumps[0])
        out = name.replace(" ", "-")
        process = place.start(
            out,
            "--json",
            "--threads",
            "1",
            LD_PRELOAD=str(library),
            FAKETIME_TIMESTAMP_FILE=str(setting),
            FAKETIME_NO_CACHE="1",
            FAKETIME_DONT_FAKE_MONOTONIC=monotonic,
        )

        def jump():
            for value in jumps[1:]:
                time.sleep(0.3)
                setting.write_text(value)

        thread = threading.Thread(target=jump)
        thread.start()
        said, errors = process.communicate(timeout=300)
        thread.join()
        if process.returncode not in (0, 3):
            note(name, f"status {process.returncode}: {errors.strip()[:200]}", False)
            continue
        walls = pl.read_parquet(place.folder / out / "points.parquet")["wall_time"]
        record = place.record(out)
        total = record["totals"]["wall_time"]
        numbers = [total, walls.min()]
        equal = same(place.tables("whole"), place.tables(out))
        note(
            name,
            f"wall time {total:.2f} s, of a point {walls.min():.1e} to {walls.max():.1e} s, "
            f"started {record['started']}, finished {record['finished']}, same tables: {equal}",
            equal and all(number >= 0 for number in numbers) and record["started"] <= record["finished"],
        )


def part_shards(work, note):
    place = Place(work / "shards", grid(20, 100, 20))
    place.run("whole")
    begun = time.monotonic()
    faults = 0
    for shard in range(1, 1001):
        status, said, _ = place.run(f"parts/{shard}", "--shard", f"{shard}/1000", "--threads", "1")
        faults += status not in (0, 3)
    took = time.monotonic() - begun
    parts = [f"parts/{shard}" for shard in range(1, 1001)]
    merged = subprocess.Popen(
        [ATLAS, "merge", *parts, "--out", "merged"], cwd=place.folder, text=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )
    peak = peak_of(merged)
    errors = merged.stderr.read().strip()
    equal = merged.returncode == 0 and same(place.tables("whole"), place.tables("merged"))
    note(
        "1000 shards of 2000 points",
        f"{took:.0f} s, {faults} failed, merged with status {merged.returncode} {errors[:200]} in {peak:.0f} MB, same tables: {equal}",
        equal and not faults,
    )


PARTS = {"cycles": part_cycles, "points": part_points, "disk": part_disk, "clocks": part_clocks, "shards": part_shards}


def main(folder, names):
    rows, faults = [], 0

    def note(what, found, good):
        nonlocal faults
        faults += not good
        rows.append(f"| {what} | {found} | {'as it should be' if good else 'FAULT'} |")
        print(rows[-1], flush=True)

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with tempfile.TemporaryDirectory() as work:
        for name in names or PARTS:
            PARTS[name](pathlib.Path(work), note)
    head = ["# Endurance", "", "`scripts/record endurance`, two shared cores.", "", "| run | found | |", "|---|---|---|"]
    keep(folder, head + rows)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])

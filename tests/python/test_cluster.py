"""A job on a cluster: Dask workers and Slurm tasks that are killed on the way, and results that are
bit for bit those of one undisturbed run.

Nothing is imitated: the daemons, the workers and `atlas` are processes of this machine. The Slurm
tests are skipped, with the reason, where its daemons are not installed or may not be started.
"""

import contextlib
import io
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import polars as pl
import pytest

import slurm_daemons
from program import ATLAS, PLACEMENT, ROOT

DASK, SLURM = ROOT / "scripts" / "cluster" / "dask", ROOT / "scripts" / "cluster" / "slurm"
SHARDS = 3


@pytest.fixture(scope="module")
def place() -> Iterator[Path]:
    """A folder with blanks in its name and a manifest of some seconds, computed undivided."""
    # Not pytest's own folder: nobody but its owner may enter that.
    with tempfile.TemporaryDirectory(prefix="atlas cluster ") as folder:
        place = Path(folder)
        text = (ROOT / "tests/data/oscillator.toml").read_text()
        longer = text.replace("count = 3", "count = 40").replace("cycles = 300", "cycles = 2000")
        assert "count = 40" in longer and "cycles = 2000" in longer
        (place / "a job.toml").write_text(longer)
        shutil.copy(ROOT / "tests/data/oscillator.modal.toml", place)
        command = [str(ATLAS), "run", "a job.toml", "--out", "whole", "--quiet"]
        assert subprocess.run(command, cwd=place).returncode in (0, 3)
        yield place


@pytest.fixture(scope="module")
def slurm() -> Iterator[slurm_daemons.SlurmCluster]:
    reason = slurm_daemons.missing()
    if reason:
        pytest.skip(reason)
    with tempfile.TemporaryDirectory(prefix="atlas-slurm-") as folder:
        cluster = slurm_daemons.SlurmCluster(Path(folder))
        yield cluster
        cluster.stop()


def physics(folder: Path) -> dict[str, bytes]:
    """Every table of a run as bytes, placement left out."""
    found = {}
    for path in sorted(folder.glob("*.parquet")):
        table = pl.read_parquet(path)
        kept = table.drop([c for c in PLACEMENT if c in table.columns]).rechunk()
        buffer = io.BytesIO()
        kept.write_ipc(buffer)
        found[path.name] = buffer.getvalue()
    return found


def assert_same(place: Path, out: str) -> None:
    """The results in `out` are those of the undivided run."""
    whole, joined = physics(place / "whole"), physics(place / out)
    assert len(whole) == 3 and whole.keys() == joined.keys()
    differing = [name for name in whole if whole[name] != joined[name]]
    assert differing == []
    assert len(json.loads((place / out / "run.json").read_text())["shards"]) == SHARDS


def resumed(place: Path, out: str, shard: int) -> int:
    """Points of a shard that its last try took over from a killed one."""
    record = place / f"{out}.shards" / str(shard) / f"run.shard-{shard}-of-{SHARDS}.json"
    return json.loads(record.read_text())["totals"]["resumed"]


def at_work(place: Path, out: str) -> tuple[int, int]:
    """A shard with some points in its journal, and the process that computes it."""
    end = time.monotonic() + 60
    while time.monotonic() < end:
        for journal in place.glob(f"{out}.shards/*/.journal.*"):
            shard = journal.parent
            # Some points in it, most yet to come.
            if not 100_000 < journal.stat().st_size < 2_000_000:
                continue
            for process in map(int, filter(str.isdigit, os.listdir("/proc"))):
                try:
                    words = Path(f"/proc/{process}/cmdline").read_bytes().split(b"\0")
                except OSError:
                    continue
                if words[0].endswith(b"/atlas") and os.fsencode(shard) in words:
                    return int(shard.name), process
        time.sleep(0.005)
    raise AssertionError("no shard was met at work within a minute")


def parent(process: int) -> int:
    """The process that started another."""
    return int(Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[1])


def start(place: Path, script: Path, out: str, *options: str, **more) -> subprocess.Popen:
    """A cluster script on the manifest."""
    interpreter = [sys.executable] if script == DASK else []
    return subprocess.Popen(
        [*interpreter, script, "a job.toml", f"--out={out}", f"--atlas={ATLAS}", *options],
        cwd=place, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        start_new_session=True, **more,
    )  # fmt: skip


def ended(process: subprocess.Popen) -> str:
    """What a script said that ended well."""
    try:
        said, _ = process.communicate(timeout=90)
    finally:
        # Nothing that it started stays behind.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    assert process.returncode == 0, said
    return said


def test_dask_does_the_shard_of_a_lost_machine_again(place):
    """Two workers of a scheduler of their own; one of them and all that it started are killed."""
    with tempfile.TemporaryDirectory() as folder:
        address = Path(folder) / "scheduler.json"
        common = ["--scheduler-file", str(address), "--no-dashboard"]
        quiet = {"cwd": folder, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host=127.0.0.1"]
        processes = [subprocess.Popen([*command, "--port=0", *common], **quiet)]
        try:
            command = [sys.executable, "-m", "distributed.cli.dask_worker", "--no-nanny"]
            processes += [
                subprocess.Popen(
                    [*command, "--nthreads=1", *common], start_new_session=True, **quiet
                )
                for _ in range(2)
            ]
            end = time.monotonic() + 60
            while not address.exists():
                assert time.monotonic() < end
                time.sleep(0.05)
            where = json.loads(address.read_text())["address"]
            job = start(place, DASK, "dask", f"--scheduler={where}", f"--shards={SHARDS}")
            shard, process = at_work(place, "dask")
            worker = parent(process)
            assert worker in [p.pid for p in processes[1:]]
            os.killpg(worker, signal.SIGKILL)
            assert "results in" in ended(job)
        finally:
            for process in processes:
                process.kill()
                process.wait()
    assert resumed(place, "dask", shard) > 0
    assert_same(place, "dask")


def test_dask_ends_what_a_lost_worker_began(place):
    """Workers on this machine; one is killed, and what it started must not go on unseen."""
    job = start(place, DASK, "local", "--local=2", f"--shards={SHARDS}")
    shard, process = at_work(place, "local")
    os.kill(parent(process), signal.SIGKILL)
    assert "results in" in ended(job)
    assert resumed(place, "local", shard) > 0
    assert_same(place, "local")


def submit(place: Path, slurm: slurm_daemons.SlurmCluster, out: str, *options: str) -> str:
    """Submits the manifest; gives what was said."""
    return ended(start(place, SLURM, out, *options, env=slurm.environment))


def assert_joined(place: Path, slurm: slurm_daemons.SlurmCluster, out: str) -> None:
    """The results appear, and are those of the undivided run."""
    slurm.wait_for(lambda: (place / out).exists() or slurm.idle(), 90)
    logs = [log.read_text() for log in sorted((place / f"{out}.shards" / "logs").iterdir())]
    assert (place / out).exists(), "\n".join([*logs, slurm.logs()])
    assert_same(place, out)


def test_slurm_does_a_killed_shard_again(place, slurm):
    out = "slurm 100%a"
    said = submit(place, slurm, out, f"--shards={SHARDS}")
    assert "3 of 3 shards to compute" in said and "scancel" in said
    shard, process = at_work(place, out)
    os.kill(process, signal.SIGKILL)
    assert_joined(place, slurm, out)
    log = (place / f"{out}.shards" / "logs" / f"{shard}.log").read_text()
    assert f"shard {shard} of {SHARDS} ended with status 137, after 0 restarts" in log
    assert resumed(place, out, shard) > 0


def test_slurm_does_the_shard_of_a_lost_node_again(place, slurm):
    # With two cores a shard has the node to itself.
    out = "slurm node"
    submit(place, slurm, out, f"--shards={SHARDS}", "--threads=2")
    shard, process = at_work(place, out)
    script = parent(process)
    slurm.lose_node([parent(script), script, process])
    assert_joined(place, slurm, out)
    assert "due to node failure" in slurm.logs()
    assert resumed(place, out, shard) > 0


def test_slurm_goes_on_where_jobs_were_called_off(place, slurm):
    out = "slurm off"
    submit(place, slurm, out, f"--shards={SHARDS}")
    at_work(place, out)
    again = start(place, SLURM, out, env=slurm.environment)
    said, _ = again.communicate(timeout=30)
    assert again.returncode == 2 and "are at work on it" in said
    slurm.said("scancel", "--user=root")
    slurm.wait_for(slurm.idle)
    assert not (place / out).exists()
    said = submit(place, slurm, out, "--wait")
    assert f"of {SHARDS} shards to compute" in said and "results in" in said
    assert_same(place, out)


@pytest.mark.parametrize("script", [DASK, SLURM], ids=["dask", "slurm"])
def test_a_shard_that_is_refused_ends_the_job(place, request, script):
    """And the shards that were done are not done again, by either engine."""
    slurm = request.getfixturevalue("slurm") if script == SLURM else None
    more = {"env": slurm.environment} if slurm else {}
    where = ["--wait"] if slurm else ["--local=2"]
    out = f"spoilt for {script.name}"
    shard = place / f"{out}.shards" / "2"
    shard.mkdir(parents=True)
    journal = shard / f".journal.shard-2-of-{SHARDS}"
    journal.write_text("no journal of a run")
    job = start(place, script, out, *where, f"--shards={SHARDS}", **more)
    said, _ = job.communicate(timeout=90)
    assert job.returncode == (1 if slurm else 2), said
    assert not (place / out).exists()
    if slurm:
        # No task stays in the queue, and the merge went with the shard that it waited for.
        slurm.wait_for(slurm.idle)
        said = (shard.parent / "logs" / "2.log").read_text()
    assert "is not a journal of this program" in said
    journal.unlink()
    assert "results in" in ended(start(place, DASK, out, "--local=2"))
    assert_same(place, out)


@pytest.mark.parametrize("script", [DASK, SLURM], ids=["dask", "slurm"])
def test_shards_of_another_job_are_refused(place, request, script):
    more = {"env": request.getfixturevalue("slurm").environment} if script == SLURM else {}
    where = ["--local=1"] if script == DASK else []
    out = f"refused by {script.name}"
    folder = place / f"{out}.shards"
    folder.mkdir()
    (folder / "split").write_text("3 0123456789abcdef\n")
    job = start(place, script, out, *where, **more)
    said, _ = job.communicate(timeout=60)
    assert job.returncode == 2 and "another manifest" in said, said
    # Whatever is in the place of the results is left alone.
    (place / out).mkdir()
    (place / out / "mine").write_text("")
    job = start(place, script, out, *where, **more)
    said, _ = job.communicate(timeout=60)
    assert job.returncode == 2 and "is not empty" in said, said
    assert [p.name for p in folder.iterdir()] == ["split"]


@pytest.mark.parametrize("script", [DASK, SLURM], ids=["dask", "slurm"])
def test_a_damaged_split_is_refused_and_nothing_in_it_is_run(place, script):
    if script == SLURM and shutil.which("sbatch") is None:
        pytest.skip("no sbatch here")
    where = ["--local=1"] if script == DASK else []
    out = f"damaged for {script.name}"
    folder = place / f"{out}.shards"
    folder.mkdir()
    for content in [
        b"",
        b"\n",
        b"3",
        b"3\n",
        b"0123456789abcdef\n",
        b"0 0123456789abcdef\n",
        b"100001 0123456789abcdef\n",
        b"3 0123456789abcdef 4\n",
        b"a[$(touch pwned)] 0123456789abcdef\n",
        b"3 x[$(touch pwned)]\n",
        b"\xff\xfe\x00 3\n",
    ]:
        (folder / "split").write_bytes(content)
        job = start(place, script, out, *where)
        said, _ = job.communicate(timeout=60)
        assert job.returncode == 2, (content, said)
        lines = [line for line in said.splitlines() if "is damaged" in line]
        assert len(lines) == 1 and f"{folder}/split" in lines[0], (content, said)
        assert "Traceback" not in said and "remove" in lines[0], (content, said)
    assert not list(place.rglob("pwned"))
    assert [p.name for p in folder.iterdir()] == ["split"]
    # A file where a folder is wanted.
    for name in [f"{out} 2", f"{out} 3.shards"]:
        (place / name).write_text("mine")
        job = start(place, script, name.removesuffix(".shards"), *where)
        said, _ = job.communicate(timeout=60)
        assert job.returncode == 2 and "is a file" in said and "Traceback" not in said, said
        assert (place / name).read_text() == "mine"


def test_as_many_shards_as_atlas_takes_are_submitted(place):
    """In arguments that the system passes on. In the place of sbatch a script keeps them: no
    daemon as it is delivered would take such an array."""
    shards = 90_000
    with tempfile.TemporaryDirectory() as folder:
        sbatch = Path(folder) / "sbatch"
        sbatch.write_text(f'#!/bin/sh\nprintf "%s\\n" "$@" >>"{folder}/said"\necho 7\n')
        sbatch.chmod(0o755)
        more = {"env": os.environ | {"PATH": f"{folder}:{os.environ['PATH']}"}}
        out = "very many"
        # Every other one is finished: the longest list there is.
        for shard in range(2, 60_000, 2):
            part = place / f"{out}.shards" / str(shard)
            part.mkdir(parents=True)
            (part / f"run.shard-{shard:05}-of-{shards}.json").write_text('{\n  "state": "complete"\n')
        job = start(place, SLURM, out, f"--shards={shards}", **more)
        said, _ = job.communicate(timeout=300)
        assert job.returncode == 0, said
        assert f"60001 of {shards} shards to compute" in said
        given = (Path(folder) / "said").read_text().splitlines()
        assert f"--array=1-{shards}" in given
        shutil.rmtree(place / f"{out}.shards")
        (Path(folder) / "said").unlink()
        for shard in [1, 2, 5, 8]:
            part = place / f"{out}.shards" / str(shard)
            part.mkdir(parents=True)
            (part / f"run.shard-{shard:02}-of-12.json").write_text('{\n  "state": "complete"\n')
        job = start(place, SLURM, out, "--shards=12", **more)
        said, _ = job.communicate(timeout=60)
        assert job.returncode == 0, said
        given = (Path(folder) / "said").read_text().splitlines()
        assert "--array=3-4,6-7,9-12" in given

"""One wheel for every x86-64 processor: it chooses its instructions when it is loaded, and computes with each
set of them the bits that the program computes.

Processors without AVX-512, and without AVX2, are emulated (qemu-user)."""

import json
import shutil
import subprocess
import sys

import pyarrow.parquet as pq
import pytest

from program import ATLAS, ROOT, environment_without_instructions, same_bits

EMULATOR = shutil.which("qemu-x86_64")

RUN = 'import gearatlas; gearatlas.run("m.toml", "package", progress=False)'


def emulated(processor):
    if not EMULATOR:
        pytest.skip("qemu-x86_64 is not installed")
    return [EMULATOR, "-cpu", processor]


@pytest.fixture
def folder(tmp_path):
    text = (ROOT / "manifests/quickstart.toml").read_text()
    for known, small in [("cycles = 160000", "cycles = 600"), ("transient = 500", "transient = 100")]:
        assert known in text
        text = text.replace(known, small)
    (tmp_path / "m.toml").write_text(text)
    return tmp_path


@pytest.mark.parametrize("instructions, processor", [("avx512", None), ("avx2", "Haswell"), ("baseline", "Nehalem")])
def test_the_wheel_gives_the_programs_bits(folder, instructions, processor):
    prefix = emulated(processor) if processor else []
    # What is set for the processor of this machine breaks NumPy on an emulated one.
    place = {"cwd": folder, "env": environment_without_instructions()}
    program = [*prefix, ATLAS, "run", "m.toml", "--out", "program", "--quiet"]
    assert subprocess.run(program, **place).returncode in (0, 3)
    subprocess.run([*prefix, sys.executable, "-c", RUN], **place, check=True)
    used = {json.loads((folder / out / "run.json").read_text())["machine"]["instructions"][0] for out in ("program", "package")}
    if processor is None and used == {"avx2"}:
        pytest.skip("this processor has no AVX-512")
    assert used == {instructions}
    for name in ("points", "poincare"):
        same_bits(*(pq.read_table(folder / out / f"{name}.parquet") for out in ("program", "package")))

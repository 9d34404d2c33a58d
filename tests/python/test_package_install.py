"""From a wheel to a map of exponents on the screen, in an environment that has nothing else."""

import os
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest

from test_pages import Home

ROOT = Path(__file__).resolve().parents[2]
WHEELS = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "wheels"

FIRST_STEPS = """
import gearatlas
results = gearatlas.run({manifest!r})
for row in results.points.on_grid("lambda_max"):
    print(*(f"{{value:8.4f}}" for value in row))
for convert in [results.points.to_pandas, results.points.to_polars, lambda: results.points.quantity("speed")]:
    try:
        convert()
    except ImportError as error:
        print(error)
"""


def newest_wheel() -> Path:
    wheels = sorted(WHEELS.glob("gearatlas-*.whl"))
    if not wheels:
        pytest.skip("no wheel: scripts/wheel builds it")
    return wheels[-1]


def installed(wheel: Path, folder: Path) -> Path:
    """The Python of a fresh environment with a wheel and what it needs."""
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    subprocess.run([folder / "bin/python", "-m", "pip", "install", "--quiet", wheel], check=True)
    return folder / "bin/python"


def test_a_wheel_brings_the_program(tmp_path):
    wheel = newest_wheel()
    if "gearatlas/bin/atlas" not in zipfile.ZipFile(wheel).namelist():
        pytest.skip("no program in the wheel: cargo build --release, then scripts/wheel")
    program = installed(wheel, tmp_path / "venv").with_name("atlas")
    home = Home(tmp_path / "home", program)
    assert home.run("atlas --version").startswith("atlas ")
    home.run("atlas new my-drive && atlas check my-drive.toml")
    assert home.run("atlas fmu my-drive.toml --out drive.fmu"), "its library for FMUs lies beside it"
    assert "Usage" in home.run("atlas run --help")
    refused = subprocess.run([program, "check", "none.toml"], cwd=tmp_path, capture_output=True, text=True)
    assert refused.returncode == 2 and "none.toml" in refused.stderr, "its status is that of the program"


def test_a_package_without_the_program_says_so(tmp_path, monkeypatch):
    from gearatlas import _program

    monkeypatch.setattr(_program, "PROGRAM", tmp_path / "atlas")
    with pytest.raises(SystemExit, match="cargo install"):
        _program.main()


def test_a_fresh_environment_shows_a_map(tmp_path):
    wheel = newest_wheel()
    began = time.monotonic()
    python = installed(wheel, tmp_path / "venv")
    program = FIRST_STEPS.format(manifest=str(ROOT / "manifests/quickstart.toml"))
    shown = subprocess.run([python, "-c", program], check=True, capture_output=True, text=True, cwd=tmp_path)
    print(f"{time.monotonic() - began:.1f} s from the wheel to\n{shown.stdout}")
    *grid, pandas, polars, pint = shown.stdout.splitlines()
    rows = [[float(value) for value in line.split()] for line in grid]
    assert [len(row) for row in rows] == [4, 4, 4]
    assert max(max(row) for row in rows) > 0
    assert pandas == "pandas is not installed; install it with `pip install pandas pyarrow`"
    assert polars == "polars is not installed; install it with `pip install polars`"
    assert pint == "pint is not installed; install it with `pip install pint`"

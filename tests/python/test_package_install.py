"""From a wheel to a map of exponents on the screen, in an environment that has nothing else."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

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


def test_a_fresh_environment_shows_a_map(tmp_path):
    wheels = sorted(WHEELS.glob("gearatlas-*.whl"))
    if not wheels:
        pytest.skip("no wheel: scripts/wheel builds it")
    began = time.monotonic()
    subprocess.run([sys.executable, "-m", "venv", tmp_path / "venv"], check=True)
    python = tmp_path / "venv/bin/python"
    subprocess.run([python, "-m", "pip", "install", "--quiet", wheels[-1]], check=True)
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

"""Figures of README.md and of pages of docs/ are those of the records under benches/runs/."""

import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("script", ["front_page", "gpu_reckoning", "other_pages", "record_half_gap", "replication"])
def test_measured_figures_are_the_records(script):
    done = subprocess.run(
        [sys.executable, ROOT / f"scripts/records/{script}.py", "--check"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr

"""README's measured figures are those of the records under benches/runs/."""

import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


def test_measured_figures_are_the_records():
    done = subprocess.run(
        [sys.executable, ROOT / "scripts/front_page.py", "--check"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr

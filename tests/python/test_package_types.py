"""The types of the Python package: its own code, its stubs, and a program that uses it, by mypy --strict."""

import subprocess
import sys
from pathlib import Path

import gearatlas
from gearatlas import _gearatlas

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "python" / "atlas"

PROGRAM = """\
import numpy as np
import gearatlas

manifest: gearatlas.Manifest = gearatlas.load("m.toml", set={"mesh.half_gap": "20 um"})
results = gearatlas.run(manifest, "out", threads=2, progress=lambda progress: print(progress.done))
exponents: np.ndarray = results.points["lambda_max"]
mapped = gearatlas.CycleMap(manifest.point(load=0.1))
image = mapped.image(np.zeros((3, mapped.dimension)), 2, jacobian=True, by=["load"])
if image.jacobian is not None:
    determinant: float = float(np.linalg.det(image.jacobian[0]))
units: dict[str, str] = results.points.units
few: gearatlas.Table = results["points"][results.points["load"] > 0.1][["load", "speed"]]
loads: list[float] = [row["load"] for row in few[2:]]
last: dict[str, object] = few[-1]
swept: gearatlas.Results = gearatlas.sweep(manifest, {"mesh.half_gap": [1e-5, 2e-5]}, load=0.1)
largest = float(swept.to_xarray()["lambda_max"].max())
"""

WRONG = """\
import gearatlas

gearatlas.run(3)
gearatlas.load("m.toml").point(load=[1])
"""


def checked(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file", ROOT / "pyproject.toml", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT / "python")


def test_the_package_is_typed():
    done = checked("-p", "gearatlas")
    assert done.returncode == 0, done.stdout


def test_programs_that_use_it_are_checked(tmp_path):
    (tmp_path / "program.py").write_text(PROGRAM)
    done = checked(tmp_path / "program.py")
    assert done.returncode == 0, done.stdout
    (tmp_path / "wrong.py").write_text(WRONG)
    found = checked(tmp_path / "wrong.py")
    assert found.returncode == 1 and found.stdout.count("[arg-type]") == 2, found.stdout


def test_the_stubs_are_those_of_what_was_compiled():
    done = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "gearatlas._gearatlas", "--ignore-disjoint-bases"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout
    assert (Path(gearatlas.__file__).parent / "py.typed").exists()
    assert _gearatlas.__version__ == gearatlas.__version__

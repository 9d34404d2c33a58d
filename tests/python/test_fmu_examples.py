"""examples/fmu.py and examples/fmu_drive_line.py print what they promise."""

import os
import subprocess
import sys

import numpy as np
import pytest

from program import ATLAS, ROOT

pytest.importorskip("fmpy")


def lines(name, *arguments):
    environment = os.environ | {"PATH": f"{ATLAS.parent}{os.pathsep}{os.environ['PATH']}"}
    command = [sys.executable, ROOT / "examples" / name, *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True, env=environment).stdout.splitlines()


def test_the_drive_rattles_until_it_is_loaded():
    table = np.array([line.split() for line in lines("fmu.py")[1:]], dtype=float)
    time, torque, pinion, wheel, _, events = table.T
    assert time[-1] == pytest.approx(0.3) and torque[-1] == 50
    np.testing.assert_allclose(pinion / wheel, 1.5, rtol=1e-3)
    assert events[time < 0.1].min() > 0 and events[time > 0.2].max() == 0


def test_the_drive_line_rattles_when_its_torque_turns(tmp_path):
    phases = {line.split()[0]: line.split() for line in lines("fmu_drive_line.py", tmp_path / "line.png")}
    assert [int(phases[name][1]) for name in ("drive", "coast", "load")] == [0, 0, 0]
    assert int(phases["tip-out"][1]) > 50 and int(phases["tip-in"][1]) > 5
    lowest, highest = (float(phases["tip-in"][place]) for place in (5, 7))
    assert lowest < 0 and highest > float(phases["load"][7])
    assert (tmp_path / "line.png").read_bytes().startswith(b"\x89PNG")

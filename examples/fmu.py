#!/usr/bin/env python3
"""Steps the drive of manifests/quickstart.toml as an FMU through FMPy. Prints speeds, mesh force and events.

    .venv/bin/python examples/fmu.py

The load rises from 10 to 100 % of the rated torque. The drive rattles until its flanks stay in contact.
"""

import shutil
import subprocess
import tempfile
from pathlib import Path

import fmpy
import numpy as np
from fmpy.simulation import instantiate_fmu

ROOT = Path(__file__).resolve().parents[1]
ATLAS = shutil.which("atlas") or ROOT / "target/release/atlas"
STEP, STEPS = 1e-3, 300  # s
RATED, RATIO = 50.0, 1.5  # N m on the pinion; teeth of the wheel per tooth of the pinion
OUTPUTS = ("pinion.speed", "wheel.speed", "mesh.force")


def simulate(folder: Path) -> np.ndarray:
    """A row for each step: time, torque on the pinion, the outputs, events."""
    file = folder / "drive.fmu"
    subprocess.run([ATLAS, "fmu", ROOT / "manifests/quickstart.toml", "--out", file], check=True, stdout=subprocess.DEVNULL)
    description = fmpy.read_model_description(str(file))
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    torques = [references["pinion.torque"], references["wheel.torque"]]
    outputs = [references[name] for name in OUTPUTS]
    drive = instantiate_fmu(fmpy.extract(str(file), str(folder / "drive")), description, "CoSimulation")
    drive.setupExperiment(startTime=0.0)
    drive.enterInitializationMode()
    drive.exitInitializationMode()
    rows, events = [], 0
    for time in STEP * np.arange(STEPS):
        torque = RATED * np.interp(time, [0.1, 0.2], [0.1, 1.0])
        drive.setReal(torques, [torque, -RATIO * torque])
        drive.doStep(time, STEP)
        before, (events,) = events, drive.getInteger([references["events"]])
        rows.append([time + STEP, torque, *drive.getReal(outputs), events - before])
    drive.terminate()
    drive.freeInstance()
    return np.array(rows)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        table = simulate(Path(folder))
    names = ("time [s]", "torque [N m]", "pinion [rad/s]", "wheel [rad/s]", "mesh force [N]", "events in a step")
    print("".join(f"{name:>18}" for name in names))
    for row in table[9::10]:
        print("".join(f"{value:18.6g}" for value in row))

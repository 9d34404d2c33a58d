#!/usr/bin/env python3
"""Tip-in and tip-out of a light vehicle: an FMU of its gears between an engine and an elastic half shaft with a mass.

    .venv/bin/python examples/fmu_drive_line.py [FILE.png]

The gears are those of manifests/quickstart.toml, with a flywheel on the pinion. The engine has four cylinders and four
strokes: its torque has two periods per turn. The half shaft is a spring with a damper. Both torques on the FMU are straight
lines over a step. That of the engine has its derivative as slope, that of the half shaft its change over the last step.
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import fmpy
import matplotlib.pyplot as plt
import numpy as np
from fmpy.simulation import instantiate_fmu

ROOT = Path(__file__).resolve().parents[1]
ATLAS, MANIFEST = shutil.which("atlas") or ROOT / "target/release/atlas", ROOT / "manifests/quickstart.toml"
DRIVE = ("--set=grid.load=0.6", "--set=grid.speed=3000 rpm", "--set=shafts.pinion.end_inertia=0.02 kg*m^2")
STEP, END, RATIO = 1e-4, 1.5, 1.5  # s; teeth of the wheel per tooth of the pinion
THROTTLE = ([0.3, 0.32, 0.9, 0.92], [30.0, -10.0, -10.0, 50.0])  # s, mean torque of the engine in N m
RIPPLE, ORDER = 0.8, 2  # amplitude by mean torque; periods per turn
SHAFT, DAMPER, INERTIA = 400.0, 2.0, 13.5  # N m/rad, N m s/rad, kg m2: 150 kg on wheels of 0.3 m
PHASES = {"drive": (0.1, 0.3), "tip-out": (0.3, 0.6), "coast": (0.6, 0.9), "tip-in": (0.9, 1.2), "load": (1.2, 1.5)}
INPUTS, ENDS = ("pinion.torque", "wheel.torque"), ("pinion.angle", "pinion.speed", "wheel.angle", "wheel.speed")
OUTPUTS = ("pinion.speed", "wheel.speed", "mesh.force", "mesh.deflection")


def start(folder: Path):
    """The FMU in step mode, and the numbers of its variables."""
    file = folder / "drive.fmu"
    subprocess.run([ATLAS, "fmu", MANIFEST, *DRIVE, "--out", file], check=True, stdout=subprocess.DEVNULL)
    description = fmpy.read_model_description(str(file))
    drive = instantiate_fmu(fmpy.extract(str(file), str(folder / "drive")), description, "CoSimulation")
    drive.setupExperiment(startTime=0.0)
    drive.enterInitializationMode()
    drive.exitInitializationMode()
    return drive, {variable.name: variable.valueReference for variable in description.modelVariables}


def simulate(folder: Path) -> np.ndarray:
    """A row for each step: time, torques of engine and half shaft, speed of the vehicle, outputs, events so far."""
    drive, references = start(folder)
    inputs, ends, outputs = ([references[name] for name in names] for names in (INPUTS, ENDS, OUTPUTS))
    *_, angle, speed = drive.getReal(ends)
    torque, rate, rows = -drive.getReal(inputs)[1], 0.0, []
    resistance, angle = torque, angle - torque / SHAFT  # In balance.
    for time in STEP * np.arange(round(END / STEP)):
        turned, pace, *_ = drive.getReal(ends)
        mean, after = np.interp([time, time + STEP], *THROTTLE)
        ripple, steepness = 1 + RIPPLE * np.cos(ORDER * turned), -RIPPLE * ORDER * pace * np.sin(ORDER * turned)
        engine, growth = mean * ripple, (after - mean) / STEP * ripple + mean * steepness
        drive.setReal(inputs, [engine, -torque])
        drive.setRealInputDerivatives(inputs, [1, 1], [growth, -rate])
        drive.doStep(time, STEP)
        # The vehicle under the same torque.
        first, change = (torque - resistance) / INERTIA, rate / INERTIA
        angle += STEP * (speed + STEP * (first / 2 + STEP * change / 6))
        speed += STEP * (first + STEP * change / 2)
        (*_, turned, pace), before = drive.getReal(ends), torque
        torque = SHAFT * (turned - angle) + DAMPER * (pace - speed)
        rate = (torque - before) / STEP
        rows.append([time + STEP, engine, torque, speed, *drive.getReal(outputs), *drive.getInteger([references["events"]])])
    drive.freeInstance()
    return np.array(rows)


def plot(table: np.ndarray, file: Path) -> None:
    time, engine, shaft, vehicle, pinion, wheel, force, deflection, events = table.T
    curves = [
        ("torque [N m]", {"engine": engine, "half shaft by the ratio": shaft / RATIO}),
        ("speed [rad/s]", {"pinion by the ratio": pinion / RATIO, "vehicle": vehicle}),
        ("mesh force [N]", {"": force}),
        ("deflection [µm]", {"": 1e6 * deflection}),
        ("events in 5 ms", {"": np.diff(events[::50], append=events[-1]).repeat(50)}),
    ]
    figure, frames = plt.subplots(len(curves), sharex=True, figsize=(9, 11), layout="constrained")
    for frame, (label, lines) in zip(frames, curves):
        for name, values in lines.items():
            frame.plot(time, values, label=name, lw=0.7)
        frame.set_ylabel(label)
    frames[-1].set_xlabel("time [s]")
    for frame in frames[:2]:
        frame.legend(loc="upper left")
    figure.savefig(file)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        table = simulate(Path(folder))
    for name, (begin, end) in PHASES.items():
        force, events = table[round(begin / STEP) : round(end / STEP), [6, 8]].T
        print(f"{name:8} {np.ptp(events):5.0f} events, mesh force {force.min():6.0f} to {force.max():5.0f} N")
    plot(table, Path(sys.argv[1] if len(sys.argv) > 1 else "drive_line.png"))

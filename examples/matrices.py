#!/usr/bin/env python3
"""From matrices M and K of a finite-element code to a modal file and a first run.

    python examples/matrices.py [FOLDER]

The example has two torsional shafts, motor - gear and gear - machine. It writes their matrices to an .npz file in place of
an export. `python -m gearatlas.convert drive.npz` does the same without Python code.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import gearatlas
from gearatlas.convert import read
from gearatlas.modal_file import write

TEETH, BASE_RADII, RATED_TORQUE = (20, 30), (0.0376, 0.0564), 50.0


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="matrices-"))
    folder.mkdir(parents=True, exist_ok=True)
    # Rotations of motor, pinion, wheel, machine, each positive in its direction of rotation (the wheel's side runs the other way).
    spring = np.array([[1.0, -1.0], [-1.0, 1.0]])
    K = np.zeros((4, 4))
    K[:2, :2], K[2:, 2:] = 1.5e4 * spring, 2.5e4 * spring
    np.savez(
        folder / "drive.npz",
        M=np.diag([2e-3, 1.8e-3, 6e-3, 5e-3]),
        K=K,
        C=1e-6 * K,
        teeth=TEETH[0],
        teeth_wheel=TEETH[1],
        rated_force=RATED_TORQUE / BASE_RADII[0],
        # Rotating the pinion forward and the wheel backward closes the drive flanks.
        mesh=[0.0, BASE_RADII[0], BASE_RADII[1], 0.0],
        # The torques of the motor and of the machine that balance one newton of mesh force.
        torque=[BASE_RADII[0], 0.0, 0.0, BASE_RADII[1]],
        torque_pinion=[1.0, 0.0, 0.0, 0.0],
    )
    write(read(folder / "drive.npz"), folder / "drive.modal.toml")
    manifest = {
        "job": {"name": "matrices"},
        "model": {"kind": "modal", "file": "drive.modal.toml"},
        "mesh": {"half_gap": "10 um", "stiffness": "constant", "mean_stiffness": "4e8 N/m", "contact_damping": 0.05},
        "excitation": {"transmission_error": [{"harmonic": 1, "amplitude": "5 um"}]},
        "grid": {"load": 0.1, "speed": {"from": "6000 rpm", "to": "12000 rpm", "count": 7}},
        "run": {"transient": 200, "cycles": 2000},
        "analyses": {"lyapunov": {"exponents": 1, "effort": "survey"}, "nvh": {"harmonics": 5}},
    }
    results = gearatlas.run(gearatlas.Manifest.from_dict(manifest, folder=folder), folder / "results")
    for row in results.points.to_dicts():
        print(f"{row['speed']:7.1f} rad/s  {row['class']:15}  {row['deflection_pp'] * 1e6:7.2f} um peak to peak")


if __name__ == "__main__":
    main()

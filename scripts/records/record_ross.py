#!/usr/bin/env python3
"""Records the results of ROSS for the rotors of examples/ross_rotors.py: their matrices, elements of bearings and
eigenvalues. tests/python/test_package_ross.py uses them if ROSS is not installed.

    pip install ross-rotordynamics==2.3.0 "plotly<6"
    python scripts/records/record_ross.py                # writes tests/data/ross.npz
"""

import sys
from pathlib import Path

import numpy as np
import ross

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "examples"))

from ross_rotors import GEARED, rotors  # noqa: E402

SPEED = 100.0
MESH_STIFFNESS = 1e8


def main() -> None:
    arrays: dict[str, object] = {"version": ross.__version__, "speed": SPEED, "mesh_stiffness": MESH_STIFFNESS}
    pair = rotors()
    ratio = GEARED["teeth"][0] / GEARED["teeth"][1]
    for name, rotor, speed in zip(("first", "second"), pair, (SPEED, -ratio * SPEED)):
        for matrix in ("M", "K", "C"):
            arrays[f"{name}.{matrix}"] = getattr(rotor, matrix)(0.0)
        arrays[f"{name}.G"] = rotor.G()
        arrays[f"{name}.nodes"] = rotor.nodes
        for number, bearing in enumerate(rotor.bearing_elements):
            arrays[f"{name}.bearing.{number}.K"] = bearing.K(0.0)
            arrays[f"{name}.bearing.{number}.C"] = bearing.C(0.0)
            arrays[f"{name}.bearing.{number}.places"] = list(bearing.dof_global_index.values())
        modes = 2 * rotor.ndof
        arrays[f"{name}.still"] = rotor.run_modal(0.0, num_modes=modes, sparse=False).evalues
        arrays[f"{name}.turning"] = rotor.run_modal(speed, num_modes=modes, sparse=False).evalues
    coupled = ross.MultiRotor(*pair, coupled_nodes=GEARED["nodes"], gear_mesh_stiffness=MESH_STIFFNESS)
    arrays["coupled"] = coupled.run_modal(0.0, num_modes=2 * coupled.ndof, sparse=False).evalues
    np.savez_compressed(ROOT / "tests/data/ross.npz", **arrays)


if __name__ == "__main__":
    main()

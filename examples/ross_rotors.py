#!/usr/bin/env python3
"""Computes the rattle over speed of two rotors of ROSS with a spur mesh between them.

    pip install ross-rotordynamics "plotly<6"
    python examples/ross_rotors.py [FOLDER]

The rotors are a generator and a turbine, modelled as in the ROSS documentation. Source: Rao, Shiau and Chang, Theoretical analysis of
lateral response due to torsional excitation of geared rotors, Mech. Mach. Theory 33 (1998) 761-783.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import ross

import gearatlas
from gearatlas.modal_file import write
from gearatlas.ross import geared


def rotors() -> tuple[ross.Rotor, ross.Rotor]:
    steel = ross.Material(name="steel", rho=7800, E=207e9, G_s=79.5e9)

    def shaft(lengths: list[float], diameters: list[float]) -> list[ross.ShaftElement]:
        return [ross.ShaftElement(L=length, idl=0.0, odl=d, material=steel) for length, d in zip(lengths, diameters)]

    angle = np.radians(22.5)
    generator = ross.Rotor(
        shaft([0.1, 4.24, 1.16, 0.3], [0.3, 0.3, 0.22, 0.22]),
        [
            ross.DiskElement(n=1, m=525.7, Id=16.1, Ip=32.2),
            ross.DiskElement(n=2, m=116.04, Id=3.115, Ip=6.23),
            ross.GearElement(n=4, m=726.4, Id=56.95, Ip=113.9, n_teeth=328, base_diameter=1.0172, pr_angle=angle),
        ],
        [ross.BearingElement(n=node, kxx=183.9e6, kyy=200.4e6, cxx=3e3) for node in (0, 3)],
    )
    turbine = ross.Rotor(
        shaft([0.3, 5.0, 0.1], [0.15, 0.15, 0.15]),
        [
            ross.GearElement(n=0, m=5, Id=0.002, Ip=0.004, n_teeth=23, base_diameter=0.07134, pr_angle=angle),
            ross.DiskElement(n=2, m=7.45, Id=0.0745, Ip=0.149),
        ],
        [ross.BearingElement(n=node, kxx=10.1e6, kyy=41.6e6, cxx=3e3) for node in (1, 3)],
    )
    return generator, turbine


GEARED = {
    "nodes": (4, 0),
    "teeth": (328, 23),
    "base_radii": (0.5086, 0.03567),
    "pressure_angle": np.radians(22.5),
    "rated_torque": 5000.0,
    "ends": (1, 2),  # the generator's and the turbine's disc
}

MANIFEST = {
    "job": {"name": "ross"},
    "model": {"kind": "modal", "file": "drive.modal.toml"},
    "mesh": {"half_gap": "50 um", "stiffness": "constant", "mean_stiffness": "1e8 N/m", "contact_damping": 0.05},
    "excitation": {"transmission_error": [{"harmonic": 1, "amplitude": "10 um"}]},
    "grid": {"load": 0.2, "speed": {"from": "20 rpm", "to": "80 rpm", "count": 7}},
    "run": {"transient": 200, "cycles": 2000},
    "analyses": {"lyapunov": {"exponents": 1, "effort": "survey"}, "nvh": {"harmonics": 5}},
}


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp(prefix="ross-"))
    folder.mkdir(parents=True, exist_ok=True)
    write(geared(rotors(), **GEARED), folder / "drive.modal.toml", modes=20)
    results = gearatlas.run(gearatlas.Manifest.from_dict(MANIFEST, folder=folder), folder / "results")
    print(results.points.to_pandas()[["speed", "class", "lambda_max", "deflection_pp", "fraction_free"]].to_string())


if __name__ == "__main__":
    main()

"""Rotors of ROSS as modal files, held against what ROSS itself says of them.

tests/data/ross.npz is what scripts/records/record_ross.py recorded of ROSS 2.3.0; where ROSS is installed it is also asked anew."""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import gearatlas
from gearatlas.matrices import Matrices, StructureError
from gearatlas.modal_file import tables, write
from gearatlas.ross import geared

ROOT = Path(__file__).resolve().parents[2]
RECORDED = np.load(ROOT / "tests/data/ross.npz")
RATIO = 328 / 23
GEARED = {
    "nodes": (4, 0),
    "teeth": (328, 23),
    "base_radii": (0.5086, 0.03567),
    "pressure_angle": np.radians(22.5),
    "rated_torque": 5000.0,
    "ends": (1, 2),
}


class Recorded:
    """What `gearatlas.ross` asks of a rotor, from the record."""

    number_dof = 6

    def __init__(self, name: str) -> None:
        self._name = name
        self.nodes = RECORDED[f"{name}.nodes"].tolist()
        self.ndof = len(RECORDED[f"{name}.M"])
        self.bearing_elements = [self._bearing(f"{name}.bearing.{number}") for number in (0, 1)]

    @staticmethod
    def _bearing(name: str) -> SimpleNamespace:
        places = dict(enumerate(RECORDED[f"{name}.places"].tolist()))
        stiffness, damping = RECORDED[f"{name}.K"], RECORDED[f"{name}.C"]
        return SimpleNamespace(dof_global_index=places, n_link=None, K=lambda _: stiffness, C=lambda _: damping)

    def M(self, frequency: float) -> np.ndarray:
        return RECORDED[f"{self._name}.M"]

    def K(self, frequency: float) -> np.ndarray:
        return RECORDED[f"{self._name}.K"]

    def C(self, frequency: float) -> np.ndarray:
        return RECORDED[f"{self._name}.C"]

    def G(self) -> np.ndarray:
        return RECORDED[f"{self._name}.G"]


@pytest.fixture(scope="module")
def structure() -> Matrices:
    return geared((Recorded("first"), Recorded("second")), axial=True, **GEARED)


def eigenvalues(file: dict, speed: float = 0.0, stiffness: float = 0.0) -> np.ndarray:
    """Of q'' + (2ζω + D + Ω G) q' + (ω² + K_c + k w wᵀ) q = 0, as a modal file has these."""
    omega = np.array(file["frequency"])
    none = np.zeros((len(omega), len(omega)))
    damping = np.diag(2 * np.array(file["damping"]) * omega) + np.array(file.get("damping_matrix", none))
    damping += speed * np.array(file["gyroscopic_matrix"])
    springs = np.diag(omega**2) + np.array(file.get("stiffness_matrix", none))
    springs += stiffness * np.outer(file["mesh"], file["mesh"])
    return np.linalg.eigvals(np.block([[none, np.eye(len(omega))], [-springs, -damping]]))


def assert_among(theirs: np.ndarray, mine: np.ndarray, at_least: int) -> None:
    """Every oscillation that ROSS found up to 1e4 rad/s is one of ours."""
    theirs = theirs[(theirs.imag > 1.0) & (abs(theirs) < 1e4)]
    assert len(theirs) >= at_least
    for value in theirs:
        assert abs(mine - value).min() < 1e-6 * abs(value), value


def test_rotors_have_the_eigenvalues_that_ross_gives_them(structure):
    file = tables(structure)
    for state, speed in (("still", 0.0), ("turning", float(RECORDED["speed"]))):
        theirs = np.concatenate([RECORDED[f"first.{state}"], RECORDED[f"second.{state}"]])
        assert_among(theirs, eigenvalues(file, speed), at_least=20)
    # The wheel turns the other way, faster: gyroscopic terms are felt.
    assert abs(np.array(file["gyroscopic_matrix"])).max() > 0.0


def test_the_closed_mesh_has_the_frequencies_of_the_multi_rotor(structure):
    theirs = RECORDED["coupled"]
    mine = eigenvalues(tables(structure), stiffness=float(RECORDED["mesh_stiffness"]))
    # The published first four are 74, 77, 112 and 113 rad/s.
    np.testing.assert_allclose(np.sort(mine[mine.imag > 10.0].imag)[:4], [74, 77, 112, 113], atol=1.0)
    assert_among(theirs, mine, at_least=20)


def test_axial_motion_is_left_out(structure):
    held = geared((Recorded("first"), Recorded("second")), **GEARED)
    assert structure.size - held.size == len(RECORDED["first.nodes"]) + len(RECORDED["second.nodes"])
    rigid = np.array(tables(held)["frequency"]) == 0.0
    # Rotation of the generator, rotation of the turbine; axial motion would be two more.
    assert rigid.sum() == 2


def test_bearings_have_the_forces_of_their_springs(structure):
    assert list(structure.bearings) == [f"{which} {n} {axis}" for which in ("pinion", "wheel") for n in (1, 2) for axis in "xy"]
    second = structure.bearings["pinion 2 y"]
    assert second.direction[6 * 3 + 1] == 200.4e6 and np.count_nonzero(second.direction) == 1
    assert second.second is not None and second.second[6 * 3 + 1] == 3e3


def test_a_manifest_runs_on_it(tmp_path):
    held = geared((Recorded("first"), Recorded("second")), **GEARED)
    write(held, tmp_path / "drive.modal.toml", modes=16)
    manifest = {
        "job": {"name": "ross"},
        "model": {"kind": "modal", "file": "drive.modal.toml"},
        "mesh": {"half_gap": "50 um", "stiffness": "constant", "mean_stiffness": "1e8 N/m", "contact_damping": 0.05},
        "excitation": {"transmission_error": [{"harmonic": 1, "amplitude": "10 um"}]},
        "grid": {"load": 0.5, "speed": {"values": [2.0, 4.0]}},
        "run": {"transient": 200, "cycles": 2000},
        "analyses": {"lyapunov": {"exponents": 1, "effort": "survey"}, "nvh": {"harmonics": 3, "bearings": True}},
    }
    loaded = gearatlas.Manifest.from_dict(manifest, folder=tmp_path)
    natural = gearatlas.structure(loaded.point(), tables=tmp_path / "tables").natural
    theirs = np.concatenate([RECORDED["first.still"], RECORDED["second.still"]])
    lowest = np.sort(theirs[theirs.imag > 1.0].imag)[0]
    assert abs(natural["open"] - lowest).min() < 1e-2 * lowest
    points = gearatlas.run(loaded, tmp_path / "results", progress=False).points
    assert not set(points["status"]) - {"ok", "not_converged"}
    # What the mesh carries on average is what the torque presses it with.
    force = 0.5 * 5000.0 / 0.5086
    np.testing.assert_allclose(points["force_mean"], force, rtol=0.05)
    assert points.elements("bearing_rms")[:2] == ["pinion 1 x", "pinion 1 y"]


def test_what_does_not_go_together_is_refused():
    pair = (Recorded("first"), Recorded("second"))
    with pytest.raises(StructureError, match="do not match the teeth"):
        geared(pair, **GEARED | {"base_radii": (0.5, 0.5)})
    with pytest.raises(StructureError, match="no node 9"):
        geared(pair, **GEARED | {"nodes": (9, 0)})
    flat = SimpleNamespace(number_dof=4)
    with pytest.raises(StructureError, match="4 freedoms per node"):
        geared((flat, flat), **GEARED)


def test_the_record_is_what_ross_says(structure):
    pytest.importorskip("ross")
    sys.path.insert(0, str(ROOT / "examples"))
    from ross_rotors import GEARED as of_example
    from ross_rotors import rotors

    assert of_example == GEARED
    anew = geared(rotors(), axial=True, **GEARED)
    for name in ("M", "K", "C", "G"):
        mine, recorded = getattr(anew, name), getattr(structure, name)
        np.testing.assert_allclose(mine, recorded, rtol=0, atol=1e-12 * abs(recorded).max(), err_msg=name)

"""Modal files from matrices: `gearatlas.matrices`, `gearatlas.modal_file`, `python -m gearatlas.convert`.

What a structure is known to be beforehand: modes that atlas itself assembled, hidden in matrices by a change of
freedoms; a pair of gears and a chain in closed form."""

import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.sparse

import gearatlas
from gearatlas.convert import read
from gearatlas.matrices import Contact, Matrices, StructureError, spur_mesh
from gearatlas.modal_file import tables, write

ROOT = Path(__file__).resolve().parents[2]
QUICKSTART = ROOT / "manifests/quickstart.toml"
TRANSLATIONAL = ROOT / "manifests/tiers/translational.toml"
PAIR = {"mesh": np.array([0.04, 0.06]), "torque": np.array([0.04, 0.06])}


def converted(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", "gearatlas.convert", *arguments], capture_output=True, text=True)


def pair(**changed: object) -> dict[str, object]:
    """Two inertias without a spring, and a mesh."""
    arrays = {"M": np.diag([2e-3, 5e-3]), "K": np.zeros((2, 2)), "teeth": 20, "rated_force": 1330.0, **PAIR}
    return {name: value for name, value in (arrays | changed).items() if value is not None}


@pytest.fixture(scope="module")
def hidden(tmp_path_factory) -> tuple[gearatlas.Structure, Path]:
    """The modes of quickstart, and an .npz file of matrices over other freedoms u, q = R u."""
    found = gearatlas.structure(gearatlas.load(QUICKSTART).point())
    modes = found.modes
    count = modes.rows
    change = np.eye(count) + 0.2 * np.random.default_rng(1).normal(size=(count, count))
    omega, zeta = modes["frequency"], modes["damping"]
    named = {"mesh": "mesh", "mesh_tilt": "mesh_tilt", "mesh_coast": "coast", "torque": "torque"}

    def over_freedoms(diagonal: np.ndarray) -> np.ndarray:
        matrix = change.T @ np.diag(diagonal) @ change
        return (matrix + matrix.T) / 2

    path = tmp_path_factory.mktemp("hidden") / "drive.npz"
    np.savez(
        path,
        M=over_freedoms(np.ones(count)),
        K=over_freedoms(omega**2),
        C=over_freedoms(2 * zeta * omega),
        teeth=20,
        teeth_wheel=30,
        rated_force=50.0 / (0.04 * np.cos(np.radians(20.0))),
        **{name: change.T @ modes[column] for name, column in named.items()},
    )
    return found, path


def test_modes_hidden_in_matrices_are_found(hidden, tmp_path):
    found, source = hidden
    done = converted(source, "--out", tmp_path / "drive.modal.toml")
    assert done.returncode == 0, done.stderr
    assert "12 modes, 2 of them rigid" in done.stdout
    file = tomllib.loads((tmp_path / "drive.modal.toml").read_text())
    modes = found.modes
    np.testing.assert_allclose(file["frequency"], modes["frequency"], rtol=1e-9)
    # C was modal: it is ratios again, which every kernel takes.
    assert "damping_matrix" not in file
    np.testing.assert_allclose(file["damping"], modes["damping"], rtol=1e-7)
    elastic = modes["frequency"] > 0.0
    for name, column in {"mesh": "mesh", "mesh_coast": "coast", "torque": "torque"}.items():
        mine, own = np.array(file[name]), modes[column]
        np.testing.assert_allclose(abs(mine[elastic]), abs(own[elastic]), rtol=0, atol=1e-8 * abs(own).max())
        # Rigid motions come in any basis; products of participations do not depend on it.
        np.testing.assert_allclose(mine[~elastic] @ mine[~elastic], own[~elastic] @ own[~elastic], rtol=1e-9)
    signs = np.sign(np.array(file["mesh"]) * modes["mesh"])[elastic]
    own = signs * np.array(file["torque"])[elastic]
    np.testing.assert_allclose(own, modes["torque"][elastic], rtol=0, atol=1e-8)


def test_a_run_of_a_converted_drive_is_that_of_the_drive(hidden, tmp_path):
    _, source = hidden
    write(read(source), tmp_path / "drive.modal.toml")
    manifest = tomllib.loads(QUICKSTART.read_text())
    modal = {key: table for key, table in manifest.items() if key not in ("gear", "shafts")}
    modal["model"] = {"kind": "modal", "file": str(tmp_path / "drive.modal.toml")}
    # A modal file has no contact ratio.
    modal["mesh"] = {
        key: value for key, value in manifest["mesh"].items() if key not in ("contact_ratio", "single_pair_drop")
    } | {"stiffness": "constant"}
    drawn = manifest | {"mesh": modal["mesh"]}
    changed = {"grid.load": {"values": [0.3, 0.6]}, "run.cycles": 400}
    mine = gearatlas.run(modal, set=changed, progress=False).points
    theirs = gearatlas.run(drawn, set=changed, progress=False).points
    # After 400 cycles the verdict on motions that do not repeat (chaotic, or not converged) may hang on round-off.
    repeats = np.isin(theirs["class"], ["steady_contact", "periodic"])
    assert repeats.sum() >= 3
    assert (np.isin(mine["class"], ["steady_contact", "periodic"]) == repeats).all()
    assert (mine["class"] == theirs["class"])[repeats].all()
    for column in (
        "deflection_mean",
        "deflection_rms",
        "deflection_pp",
        "force_mean",
        "force_std",
        "force_peak",
        "fraction_drive",
        "events_per_cycle",
        "lambda_max",
    ):
        own = theirs[column][repeats]
        np.testing.assert_allclose(mine[column][repeats], own, rtol=1e-6, atol=1e-9 * abs(own).max(), err_msg=column)


def test_two_inertias_are_rigid(tmp_path):
    np.savez(tmp_path / "pair.npz", **pair())
    file = tables(read(tmp_path / "pair.npz"))
    assert file["frequency"] == [0.0, 0.0]
    # 1/m_e = r₁²/J₁ + r₂²/J₂.
    assert np.square(file["mesh"]).sum() == pytest.approx(0.04**2 / 2e-3 + 0.06**2 / 5e-3, rel=1e-14)


def test_a_chain_has_the_frequencies_of_its_closed_form(tmp_path):
    count, mass, stiffness = 2000, 0.5, 1e6
    K = scipy.sparse.diags([-np.ones(count - 1), np.full(count, 2.0), -np.ones(count - 1)], [-1, 0, 1]).tolil()
    K[0, 0] = K[-1, -1] = 1.0
    scipy.io.mmwrite(tmp_path / "K.mtx", stiffness * K.tocsc(), symmetry="symmetric")
    scipy.io.mmwrite(tmp_path / "M.mtx", mass * scipy.sparse.eye(count, format="csc"), symmetry="symmetric")
    (tmp_path / "chain.toml").write_text(
        f'M = "M.mtx"\nK = "K.mtx"\nteeth = 20\nrated_force = 100\n'
        f"[mesh]\n1 = 1.0\n[torque]\n1 = 1.0\n[contact.stop.direction]\n{count} = -1\n"
        "[contact.stop]\ngap = 1e-4\nstiffness = 1e7\n[bearing.'the end, x'.direction]\n1 = 2e6\n"
    )
    done = converted(tmp_path / "chain.toml", "--modes", "12", "--damping", "0.02")
    assert done.returncode == 0, done.stderr
    file = tomllib.loads((tmp_path / "chain.modal.toml").read_text())
    exact = 2.0 * np.sqrt(stiffness / mass) * np.sin(np.arange(12) * np.pi / (2 * count))
    assert file["frequency"][0] == 0.0
    np.testing.assert_allclose(file["frequency"], exact, rtol=1e-8)
    assert file["damping"] == [0.0] + [0.02] * 11
    # The ends of mode j have the amplitude √(2/(m n)) cos(jπ/2n).
    ends = np.sqrt(2.0 / (mass * count)) * np.cos(np.arange(1, 12) * np.pi / (2 * count))
    np.testing.assert_allclose(np.abs(file["mesh"][1:]), ends, rtol=1e-6)
    stop, bearing = file["contact"][0], file["bearing"][0]
    assert (stop["name"], stop["gap"], stop["stiffness"]) == ("stop", 1e-4, 1e7)
    np.testing.assert_allclose(np.abs(stop["participation"][1:]), ends, rtol=1e-6)
    assert bearing["name"] == "the end, x"
    np.testing.assert_allclose(bearing["gain"], 2e6 * np.array(file["mesh"]), rtol=1e-12)
    again = converted(tmp_path / "chain.toml", "--modes", "12")
    assert again.returncode == 2 and "already exists" in again.stderr


def test_free_bodies_coupled_by_mass_are_rigid(tmp_path):
    """K = diag(3e7, 1e7, 0, 0), a free mass on either spring's: an eigenvalue solver leaves their modes 1e-16 of the
    springs' freedoms, energies of 1e-24 1/s² and as much damping. Elastic: ω² = k/(m − c²/M), c the mass between."""
    M = np.diag([0.02, 3.0, 0.5, 0.004])
    M[0, 2] = M[2, 0] = 0.03
    M[1, 3] = M[3, 1] = 0.03
    K = np.diag([3e7, 1e7, 0.0, 0.0])
    direction = np.ones(4)
    structure = Matrices(
        M=M, K=K, C=1e-6 * K, directions={"mesh": direction, "torque": direction}, teeth=20, rated_force=100.0
    )
    file = write(structure, tmp_path / "drive.modal.toml")
    stiff = np.array([1e7 / (3.0 - 0.03**2 / 0.004), 3e7 / (0.02 - 0.03**2 / 0.5)]) ** 0.5
    assert file["frequency"][:2] == [0.0, 0.0]
    np.testing.assert_allclose(file["frequency"][2:], stiff, rtol=1e-12)
    assert "damping_matrix" not in file
    np.testing.assert_allclose(file["damping"], [0.0, 0.0, *(0.5e-6 * stiff)], rtol=1e-12)


def test_soft_modes_that_the_program_refuses_are_not_written():
    soft = Matrices(M=np.diag([1.0, 1.0]), K=np.diag([1.0, 1e12]), directions=PAIR, teeth=20, rated_force=100.0)
    with pytest.raises(StructureError, match="1 rad/s beside one of 1e\\+06 rad/s"):
        tables(soft)
    assert tables(soft, modes=1)["frequency"] == [1.0]


def test_what_is_not_modal_becomes_matrices():
    M, K = np.diag([1.0, 2.0]), np.diag([1e6, 8e6])
    C, G, Kc = np.array([[3.0, 1.0], [1.0, 4.0]]), np.array([[0.0, 0.3], [-0.3, 0.0]]), np.array([[0.0, 5e3], [0.0, 0.0]])
    file = tables(
        Matrices(M, K, PAIR, teeth=20, rated_force=1.0, C=C, G=G, Kc=Kc, bearings={"b": Contact(PAIR["mesh"])})
    )
    scale = 1.0 / np.sqrt(np.outer([1.0, 2.0], [1.0, 2.0]))
    np.testing.assert_allclose(file["frequency"], [1e3, 2e3])
    for name, matrix in (("damping_matrix", C), ("gyroscopic_matrix", G), ("stiffness_matrix", Kc)):
        np.testing.assert_allclose(file[name], matrix * scale, rtol=1e-12)
    assert file["damping"] == [0.0, 0.0]


def test_gyroscopic_terms_may_be_those_at_a_speed(tmp_path):
    np.savez(tmp_path / "pair.npz", **pair(G=np.array([[0.0, 50.0], [-50.0, 0.0]])))
    by_speed = read(tmp_path / "pair.npz", gyroscopic_at=100.0)
    np.testing.assert_array_equal(by_speed.G, [[0.0, 0.5], [-0.5, 0.0]])


def test_directions_of_a_spur_mesh_are_those_of_a_drawn_drive():
    """The translational drive: rotations and radial motion of two gears, whose mesh atlas assembles itself."""
    found = gearatlas.structure(gearatlas.load(TRANSLATIONAL).point())
    elastic = found.modes["frequency"] > 0.0
    omega = found.modes["frequency"][elastic]
    # Each elastic mode is x or y of one gear, of the mass k/ω²; two bearings carry a shaft.
    along, across = (2.5e8, np.sin(np.radians(20.0))), (2e8, np.cos(np.radians(20.0)))
    own = spur_mesh((0.04 * np.cos(np.radians(20.0)), 0.06 * np.cos(np.radians(20.0))), np.radians(20.0))
    for place, mode in enumerate(np.flatnonzero(elastic)):
        squares = [found.modes[column][mode] ** 2 for column in ("mesh", "coast", "friction")]
        sums = [
            [own[name][axis] ** 2 * omega[place] ** 2 / stiffness for name in ("mesh", "mesh_coast", "friction")]
            for axis, (stiffness, _) in enumerate((along, across))
        ]
        apart = [np.abs(np.subtract(squares, each)).max() for each in sums]
        axis = int(np.argmin(apart))
        assert apart[axis] < 1e-9 * max(squares)
        product = found.modes["mesh"][mode] * found.modes["coast"][mode]
        assert np.sign(product) == np.sign(own["mesh"][axis] * own["mesh_coast"][axis])
    # The rotation of the whole drive does no work on the flanks, and friction at the pitch point none on it.
    rolling = np.array([0.0, 0.0, 1.0, 0.0, 0.0, -20 / 30])
    for name in ("mesh", "mesh_coast", "friction", "friction_coast"):
        assert abs(own[name] @ rolling) < 1e-15, name
    # Forces of a pair at rest have no resultant.
    for direction in own.values():
        np.testing.assert_allclose(direction[:2] + direction[3:5], 0.0)


BAD = {
    "K is not square": (pair(K=np.zeros((2, 3))), "`K` has the shape"),
    "sizes differ": (pair(K=np.zeros((3, 3))), "`K` is 3 by 3, but `M` is 2 by 2"),
    "K is not symmetric": (pair(K=np.array([[1.0, 2.0], [0.0, 1.0]])), "`K` is not symmetric"),
    "M is not symmetric": (pair(M=np.array([[1.0, 0.2], [0.0, 1.0]])), "`M` is not symmetric"),
    "G is not skew": (pair(G=np.ones((2, 2))), "`G` is not skew"),
    "a number is missing": (pair(K=np.array([[np.nan, 0.0], [0.0, 0.0]])), "`K` has entries that are not finite"),
    "a freedom has no mass": (pair(M=np.diag([1.0, 0.0])), "freedom 2 has no mass"),
    "M is indefinite": (pair(M=np.array([[1.0, 2.0], [2.0, 1.0]])), "`M` is not positive definite"),
    "K is indefinite": (pair(K=np.diag([1e6, -1e6])), "`K` is not positive semidefinite"),
    "no mesh": (pair(mesh=None), "`mesh` is missing"),
    "no teeth": (pair(teeth=None), "`teeth` is missing"),
    "half a tooth": (pair(teeth=20.5), "`teeth` is 20.5"),
    "a direction is short": (pair(torque=np.ones(1)), "`torque` has the shape (1,)"),
    "a name is misspelt": (pair(torq=np.ones(2)), "`torq` is not a known name"),
    "texts": (pair(K=np.array([["a", "b"], ["c", "d"]])), "`K` contains <U1"),
    "complex": (pair(K=np.eye(2) * 1j), "`K` is complex"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_no_structure_is_refused(name, tmp_path):
    arrays, expected = BAD[name]
    np.savez(tmp_path / "bad.npz", **arrays)
    done = converted(tmp_path / "bad.npz")
    assert done.returncode == 2 and not (tmp_path / "bad.modal.toml").exists()
    assert expected in done.stderr and "bad.npz" in done.stderr and "Traceback" not in done.stderr, done.stderr


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ("101, 1, 101, 1, 9.89e+01\n101, 2, 101, 1, 3.57e+01\n", "node, freedom, node, freedom, value, as Abaqus"),
        ("1 1 2.5\n2 1 -1.0\n", "%%MatrixMarket matrix coordinate real general"),
        ("stiffness of the drive\n", "scipy.io.mmwrite"),
    ],
)
def test_other_mtx_files_are_told_how_to_become_one(lines, expected, tmp_path):
    (tmp_path / "K.mtx").write_text(lines)
    (tmp_path / "drive.toml").write_text('K = "K.mtx"\n')
    with pytest.raises(StructureError, match=r"`K`: .*K\.mtx .*not a Matrix Market file") as raised:
        read(tmp_path / "drive.toml")
    assert expected in str(raised.value)


def test_files_that_are_none_are_refused(tmp_path):
    (tmp_path / "bad.npz").write_bytes(b"PK\x03\x04 no archive")
    (tmp_path / "object.npz").touch()
    np.savez(tmp_path / "object.npz", M=np.array([object()]), allow_pickle=True)
    (tmp_path / "bad.toml").write_text('M = "absent.mtx"\n')
    (tmp_path / "market.toml").write_text('M = "bad.npz"\n')
    (tmp_path / "drive.mat").touch()
    for name in ("bad.npz", "object.npz", "bad.toml", "market.toml", "drive.mat", "absent.npz"):
        with pytest.raises(StructureError, match=name.replace(".", r"\.")):
            read(tmp_path / name)

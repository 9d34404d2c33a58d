"""Housing files: `gearatlas.housing`, its readers of finite-element files, transfer functions."""

import re
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.sparse

import gearatlas
from gearatlas import housing
from gearatlas.housing import Housing, Node
from gearatlas.matrices import StructureError

ROOT = Path(__file__).resolve().parents[2]
TRAIN = ROOT / "manifests/trains/housing.toml"
BOX = ROOT / "manifests/trains/box.housing.toml"


@pytest.fixture(scope="module")
def box() -> Housing:
    return housing.read(BOX)


@pytest.fixture(scope="module")
def nastran():
    """pyNastran 1.4 uses a name that NumPy 2 has dropped; its other code works with both."""
    if not hasattr(np, "in1d"):
        np.in1d = np.isin
    return pytest.importorskip("pyNastran.bdf.bdf")


def labels(box: Housing) -> list[tuple[int, int]]:
    """Grids 101 to 104 for the nodes, scalar points from 1001 on for the modes."""
    nodes = [(101 + number, way) for number in range(len(box.nodes)) for way in (1, 2, 3)]
    return nodes + [(1001 + number, 0) for number in range(len(box.internal))]


def placed(box: Housing) -> dict[str, Node]:
    return {name: Node(node.position, grid=101 + number) for number, (name, node) in enumerate(box.nodes.items())}


def same(one: Housing, other: Housing, digits: float) -> None:
    for name in ("M", "K"):
        mine, theirs = getattr(one, name), getattr(other, name)
        root = np.sqrt(np.diag(theirs))
        assert np.abs((mine - theirs) / np.outer(root, root)).max() < digits, name
    assert [node.freedoms for node in one.nodes.values()] == [node.freedoms for node in other.nodes.values()]


def frequencies(file: Housing, folder: Path) -> np.ndarray:
    """Natural frequencies of the shipped train on a housing, as the program has them."""
    file.write(folder / "box.housing.toml")
    (folder / "train.toml").write_text(TRAIN.read_text())
    return gearatlas.structure(gearatlas.load(folder / "train.toml").point()).modes["frequency"][2:]


def in_millimetres(box: Housing) -> dict[str, np.ndarray]:
    """Its matrices in t, N and mm."""
    unit = np.array([1e3] * 3 * len(box.nodes) + [1.0] * len(box.internal))
    return {name: getattr(box, name) / (1e-3 * np.outer(unit, unit)) for name in ("M", "K")}


def test_a_file_is_read_as_it_was_written(box, tmp_path):
    box.write(tmp_path / "again.toml")
    again = housing.read(tmp_path / "again.toml")
    assert (again.M == box.M).all() and (again.K == box.K).all() and again.names == box.names
    assert (again.row("cover") == box.row("cover")).all()
    assert np.abs(frequencies(box, tmp_path) / gearatlas.structure(gearatlas.load(TRAIN).point()).modes["frequency"][2:] - 1).max() < 1e-12


def test_the_example_writes_the_shipped_housing(box, tmp_path):
    subprocess.run([sys.executable, ROOT / "examples/housing.py", tmp_path / "box.toml"], check=True, stdout=subprocess.DEVNULL)
    again = housing.read(tmp_path / "box.toml")
    # Modes have any sign.
    assert np.allclose(np.abs(again.M), np.abs(box.M), rtol=0, atol=1e-9) and again.names == box.names
    assert np.allclose(np.abs(again.K), np.abs(box.K), rtol=0, atol=1e-9 * np.abs(box.K).max())


def test_a_punch_file_of_pynastran_runs(box, nastran, tmp_path):
    bdf, own = nastran.BDF(debug=False), labels(box)
    for name, matrix in (("MAAX", box.M), ("KAAX", box.K)):
        # One triangle, as programs write symmetric matrices.
        pairs = [(i, j) for j in range(len(own)) for i in range(j, len(own))]
        columns, rows = [own[j] for _, j in pairs], [own[i] for i, _ in pairs]
        bdf.add_dmig(name, 6, 2, 0, 0, len(own), columns, rows, [matrix[pair] for pair in pairs])
    bdf.punch = True
    bdf.write_bdf(tmp_path / "box.pch", size=16, is_double=True)
    found = housing.from_punch(tmp_path / "box.pch", {"M": "MAAX", "K": "KAAX"}, placed(box), points=dict(box.points))
    # Sixteen columns of a field have ten digits.
    same(found, box, 1e-8)
    assert np.abs(frequencies(found, tmp_path) / frequencies(box, tmp_path) - 1).max() < 1e-8
    with pytest.raises(StructureError, match="has no matrix `KGG`; it has KAAX, MAAX"):
        housing.from_punch(tmp_path / "box.pch", {"M": "MAAX", "K": "KGG"}, placed(box))


def test_an_op4_file_of_pynastran_runs(box, nastran, tmp_path):
    op4 = pytest.importorskip("pyNastran.op4.op4")
    written = {name: (6, matrix) for name, matrix in in_millimetres(box).items()}
    op4.OP4().write_op4(tmp_path / "box.op4", written, is_binary=False)
    names = {"M": "M", "K": "K"}
    found = housing.from_op4(
        tmp_path / "box.op4", names, labels(box), placed(box), millimetres=True, points=dict(box.points)
    )
    same(found, box, 1e-13)
    assert np.abs(frequencies(found, tmp_path) / frequencies(box, tmp_path) - 1).max() < 1e-12


def output2(path: Path, matrices: dict[str, np.ndarray]) -> None:
    """An OP2 file as OUTPUT2 writes matrices; pyNastran writes none. Every record has a word for its length on both sides."""

    def record(data: bytes) -> bytes:
        return struct.pack("=i", len(data)) + data + struct.pack("=i", len(data))

    def markers(*values: int) -> bytes:
        return b"".join(record(struct.pack("=i", value)) for value in values)

    def counted(data: bytes) -> bytes:
        return markers(len(data) // 4) + record(data)

    out = counted(struct.pack("=3i", 11, 27, 26)) + counted(b"NASTRAN FORT TAPE ID CODE - ") + counted(b"XXXXXXXX") + markers(-1, 0)
    for number, (name, matrix) in enumerate(matrices.items(), 101):
        title, size = name.ljust(8).encode(), len(matrix)
        out += counted(title) + markers(-1) + counted(struct.pack("=7i", number, size, size, 6, 2, 2 * size, 0))
        out += markers(-2, 1, 0) + counted(title + struct.pack("=2i", 170, 170))
        for column, values in enumerate(matrix.T):
            out += markers(-3 - column, 1, 1) + counted(struct.pack(f"=i{size}d", 1, *values))
        out += markers(-3 - size, 1, 0, 0)
    path.write_bytes(out + markers(0))


def test_an_op2_file_runs(box, nastran, tmp_path):
    output2(tmp_path / "box.op2", {"MAA": box.M, "KAA": box.K})
    names = {"M": "MAA", "K": "KAA"}
    found = housing.from_op2(tmp_path / "box.op2", names, labels(box), placed(box), points=dict(box.points))
    same(found, box, 1e-13)
    assert np.abs(frequencies(found, tmp_path) / frequencies(box, tmp_path) - 1).max() < 1e-12


def test_matrix_market_and_abaqus_files_are_read_in_any_order(box, tmp_path):
    order = np.random.default_rng(1).permutation(len(box.names))
    shuffled = [labels(box)[index] for index in order]
    market, abaqus = {}, {}
    for name in ("M", "K"):
        matrix = getattr(box, name)[np.ix_(order, order)]
        market[name], abaqus[name] = tmp_path / f"{name}.mtx", tmp_path / f"{name}-abaqus.mtx"
        scipy.io.mmwrite(market[name], scipy.sparse.coo_array(matrix), precision=17)
        lines = (f"{i + 1} {j + 1}  {matrix[i, j]:.16e}" for i in range(len(matrix)) for j in range(i + 1))
        abaqus[name].write_text("\n".join(lines) + "\n")
    same(housing.from_matrix_market(market, shuffled, placed(box)), box, 1e-13)
    same(housing.from_abaqus(abaqus, shuffled, placed(box)), box, 1e-13)
    with pytest.raises(StructureError, match="is not a list of row, column, value"):
        housing.from_abaqus({"M": market["M"], "K": market["K"]}, shuffled, placed(box))


def test_bad_housings_are_refused(box):
    nodes = {"left": Node((0.0, 0.0, 0.0), ("x", "y"))}
    with pytest.raises(StructureError, match="`K` is not symmetric"):
        Housing(np.eye(2), np.array([[1.0, 0.5], [0.0, 1.0]]), nodes)
    with pytest.raises(StructureError, match=re.escape("`M` has the shape (3, 3), but nodes and internal freedoms have 2 freedoms")):
        Housing(np.eye(3), np.eye(2), nodes)
    with pytest.raises(StructureError, match="not finite"):
        Housing(np.eye(2), np.full((2, 2), np.nan), nodes)
    with pytest.raises(StructureError, match="there is no freedom `left z`"):
        Housing(np.eye(2), np.eye(2), nodes, points={"cover": "left z"})
    with pytest.raises(StructureError, match="has no freedom of grid 7 for node `left`"):
        housing.from_matrices({"M": box.M, "K": box.K}, labels(box), {"left": Node((0.0, 0.0, 0.0), grid=7)})


def test_transfer_functions_are_those_of_an_oscillator_and_reach_uff(tmp_path):
    mass, stiffness, damping, frequency = 2.0, 8e6, 40.0, np.linspace(10.0, 500.0, 50)
    parts = {name: np.array([[value]]) for name, value in (("M", mass), ("K", stiffness), ("C", damping))}
    one = Housing(**parts, nodes={"a": Node((0.0, 0.0, 0.0), ("x",))}, points={"cover": "a x"})
    omega = 2 * np.pi * frequency
    closed_form = -(omega**2) / (stiffness * (1 + 0.02j) + 1j * omega * damping - omega**2 * mass)
    found = housing.transfer(one, frequency, "a x", loss_factor=0.02)["cover"]
    assert np.abs(found / closed_form - 1).max() < 1e-13
    pyuff = pytest.importorskip("pyuff")
    housing.write_uff(tmp_path / "box.uff", one, frequency, ["a x"], loss_factor=0.02)
    (dataset,) = [pyuff.UFF(str(tmp_path / "box.uff")).read_sets(0)]
    assert (dataset["type"], dataset["func_type"], dataset["ordinate_axis_units_lab"].strip()) == (58, 4, "m/s^2")
    assert np.allclose(dataset["x"], frequency) and np.abs(dataset["data"] / found - 1).max() < 1e-6


def test_bearing_forces_times_transfer_functions_are_the_accelerations(box, tmp_path):
    """With all modes and no modal damping the bearings are all that moves the housing."""
    text = TRAIN.read_text()
    for old, new in (
        ("damping = 0.015", "damping = 0"),
        ("modes = 40", "modes = 92"),
        ('{ values = ["5 %", "20 %"] }', "1.0"),
        ('{ from = "2000 rpm", to = "8000 rpm", count = 7 }', '"3000 rpm"'),
        ("transient = 1000", "transient = 20000"),
        ('"6 um"', '"1 um"'),
    ):
        assert old in text
        text = text.replace(old, new)
    damped = Housing(box.M, box.K, box.nodes, box.internal, 2e-5 * box.K, box.points)
    damped.write(tmp_path / "box.housing.toml")
    (tmp_path / "train.toml").write_text(text)
    orders = gearatlas.run(gearatlas.load(tmp_path / "train.toml"), out=tmp_path / "results").orders
    keys = zip(orders["signal"], orders["multiple"], strict=True)
    found = dict(zip(keys, orders["amplitude"] * np.exp(1j * orders["phase"]), strict=True))
    hertz = dict(zip(orders["multiple"], orders["frequency"], strict=True))
    ways = [
        (f"bearing {shaft} {number} {way}", f"{side} {shaft} {axis}")
        for shaft in ("input", "output")
        for number, side in ((1, "left"), (2, "right"))
        for way, axis in (("x", "x"), ("y", "y"), ("axial", "z"))
    ]
    for multiple in (1, 2, 3):
        for point in box.points:
            parts = [
                found[signal, multiple] * housing.transfer(damped, hertz[multiple], freedom)[point][0]
                for signal, freedom in ways
                if (signal, multiple) in found
            ]
            off = abs(sum(parts) / found[f"acceleration housing {point}", multiple] - 1)
            print(f"{multiple} x mesh, {point}: {off:.1e}")
            assert len(parts) == 10 and off < 1e-8

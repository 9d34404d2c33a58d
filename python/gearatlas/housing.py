"""Housing files for `[train.housing]` from files of finite-element programs, and the transfer functions of a housing.

    from gearatlas import housing
    nodes = {"left": housing.Node((0, 0, 0), grid=101), "right": housing.Node((0, 0, 0.13), grid=102)}
    box = housing.from_punch("box.pch", {"M": "MAAX", "K": "KAAX"}, nodes, points={"cover": "left x"})
    box.write("box.housing.toml")
    found = housing.transfer(box, frequencies, "left x")["cover"]          # (m/s²)/N over Hz

All units are SI: matrices in kg, N and m, or in t, N and mm with `millimetres`. Readers raise `StructureError`.
Only the functions that name pyNastran, SciPy or pyuff need these packages.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ._optional import optional
from .matrices import Matrix, StructureError, Vector

FREEDOMS = ("x", "y", "z", "rx", "ry", "rz")
"""Freedoms of a node: displacements along the axes of space [m], then rotations about them [rad]."""

MOST_FREEDOMS = 400
"""Most freedoms that atlas accepts."""

ROUND_OFF = 1e-6
"""Largest difference across the diagonal from the rounding of a file, for a matrix scaled to a diagonal of ones."""

Label = tuple[int, int]
"""Grid and component of a freedom: 1 to 6 are x to rz, 0 is a scalar point such as a mode."""


@dataclass(frozen=True)
class Node:
    """A node of a housing, which can support bearings."""

    position: tuple[float, float, float]
    """Its position in space [m], in the axes of `train.shaft.*.origin`."""
    freedoms: tuple[str, ...] = FREEDOMS
    """Its freedoms, in the order of `FREEDOMS`; all others are fixed."""
    grid: int | None = None
    """Its number in the file of a finite-element program."""


@dataclass(frozen=True)
class Housing:
    """Reduced matrices over the freedoms of nodes, node by node, and internal freedoms; checked on creation.

    Raises `StructureError` if sizes do not agree or a matrix is not finite or not symmetric.
    """

    M: Matrix
    """Mass matrix [kg, kg m, kg m²]."""
    K: Matrix
    """Stiffness matrix with the supports of the housing [N/m, N, N m]."""
    nodes: Mapping[str, Node]
    internal: Sequence[str] = ()
    """Names of the internal freedoms."""
    C: Matrix | None = None
    """Viscous damping matrix [N s/m, N s, N m s]."""
    points: Mapping[str, str | Vector] = field(default_factory=dict)
    """Response points: the name of a freedom, or the displacement [m] per unit of each freedom."""

    def __post_init__(self) -> None:
        size = len(self.names)
        if not 1 <= size <= MOST_FREEDOMS:
            raise StructureError(f"the housing has {size} freedoms, but 1 to {MOST_FREEDOMS} are accepted; reduce it further")
        for name in ("M", "K", "C"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, _symmetric(name, getattr(self, name), size))
        for point in self.points:
            self.row(point)

    @property
    def names(self) -> list[str]:
        """Names of all freedoms in the order of the matrices, such as `left x`."""
        return [f"{name} {way}" for name, node in self.nodes.items() for way in node.freedoms] + list(self.internal)

    def row(self, point: str) -> Vector:
        """Displacement of a response point, or of a freedom, per unit of each freedom."""
        given = self.points.get(point, point)
        if not isinstance(given, str):
            if np.shape(given) != (len(self.names),):
                raise StructureError(f"point `{point}` has the shape {np.shape(given)}; give one number per freedom, {len(self.names)}")
            return np.asarray(given, dtype=float)
        if given not in self.names:
            raise StructureError(f"there is no freedom `{given}`; there are {', '.join(self.names[:12])}, ...")
        return np.array([float(name == given) for name in self.names])

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes the housing file that `train.housing.file` names. Raises `OSError`."""
        lines = []
        for key, matrix in (("mass", self.M), ("stiffness", self.K), ("damping", self.C)):
            if matrix is not None:
                rows = (f"    {_numbers(row)}," for row in matrix)
                lines += [f"{key} = [", *rows, "]"]
        lines += [f"internal = {_texts(self.internal)}"]
        for name, node in self.nodes.items():
            lines += ["", "[[node]]", f"name = {_text(name)}", f"position = {_numbers(node.position)}"]
            lines += [f"freedoms = {_texts(node.freedoms)}"]
        for name, given in self.points.items():
            value = f"freedom = {_text(given)}" if isinstance(given, str) else f"row = {_numbers(given)}"
            lines += ["", "[[point]]", f"name = {_text(name)}", value]
        Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


def read(path: str | os.PathLike[str]) -> Housing:
    """The housing in a housing file."""
    try:
        found = tomllib.loads(Path(path).read_text(encoding="utf-8"))
        nodes = {
            node["name"]: Node(tuple(node["position"]), tuple(node.get("freedoms", FREEDOMS))) for node in found["node"]
        }
        return Housing(
            M=np.array(found["mass"], dtype=float),
            K=np.array(found["stiffness"], dtype=float),
            C=np.array(found["damping"], dtype=float) if "damping" in found else None,
            nodes=nodes,
            internal=found.get("internal", ()),
            points={p["name"]: p["freedom"] if "freedom" in p else np.array(p["row"]) for p in found.get("point", ())},
        )
    except (KeyError, TypeError, ValueError) as error:
        raise StructureError(f"{path}: is not a housing file: {error!r}; docs/housings.md describes it") from error


def from_matrices(
    matrices: Mapping[str, Matrix],
    labels: Sequence[Label],
    nodes: Mapping[str, Node],
    *,
    points: Mapping[str, str | Vector] | None = None,
    millimetres: bool = False,
    source: str = "the matrices",
) -> Housing:
    """A housing from M, K and optionally C over freedoms in any order, with one label per freedom.

    The freedoms of the `grid` of each node become those of the node; all others become internal, named by grid and component.
    """
    place = {label: index for index, label in enumerate(labels)}
    own, order = {}, []
    for name, node in nodes.items():
        if node.grid is None:
            raise StructureError(f"{source}: node `{name}` has no grid; give Node(position, grid=number)")
        has = [(way, (node.grid, number)) for number, way in enumerate(FREEDOMS, 1) if (node.grid, number) in place]
        if not has:
            grids = sorted({grid for grid, _ in labels})
            raise StructureError(f"{source}: has no freedom of grid {node.grid} for node `{name}`; its grids are {grids[:20]}")
        own[name] = Node(node.position, tuple(way for way, _ in has), node.grid)
        order += [label for _, label in has]
    rest = sorted(set(labels) - set(order))
    index = [place[label] for label in order + rest]
    # Energies in mJ; displacements in mm; rotations and modes need no conversion.
    unit = np.array([1e3 if 1 <= component <= 3 else 1.0 for _, component in order + rest])
    scale = 1e-3 * np.outer(unit, unit) if millimetres else 1.0
    parts = {}
    for name, matrix in matrices.items():
        dense = np.asarray(matrix.todense() if hasattr(matrix, "todense") else matrix, dtype=float)
        if dense.shape != (len(labels), len(labels)):
            raise StructureError(f"{source}: `{name}` has the shape {dense.shape}, but there are {len(labels)} freedoms")
        parts[name] = dense[np.ix_(index, index)] * scale
    internal = [f"{grid} {component}" for grid, component in rest]
    return Housing(parts["M"], parts["K"], own, internal, parts.get("C"), dict(points or {}))


def from_punch(path: str | os.PathLike[str], names: Mapping[str, str], nodes: Mapping[str, Node], **more: Any) -> Housing:
    """A housing from DMIG matrices in a punch file (`.pch`), by pyNastran.

    `names` gives the names of M, K and optionally C. `more`: further arguments of `from_matrices`.
    """
    bdf = _nastran("pyNastran.bdf.bdf").BDF(log=_quiet())
    try:
        bdf.read_bdf(os.fspath(path), punch=True, xref=False)
    except OSError as error:
        raise StructureError(f"{path}: cannot be read: {error}") from error
    found = {}
    for name, wanted in names.items():
        matrix, rows, columns = _named(path, bdf.dmig, wanted).get_matrix(is_sparse=False, apply_symmetry=True)
        found[name] = (matrix, list(rows.values()), list(columns.values()))
    # A matrix contains only the freedoms with entries in it.
    labels = sorted({_label(label) for _, rows, columns in found.values() for label in rows + columns})
    place = {label: index for index, label in enumerate(labels)}
    whole = {}
    for name, (matrix, rows, columns) in found.items():
        whole[name] = np.zeros((len(labels), len(labels)))
        at = [[place[_label(label)] for label in side] for side in (rows, columns)]
        whole[name][np.ix_(*at)] = matrix
    return from_matrices(whole, labels, nodes, source=str(path), **more)


def from_op4(
    path: str | os.PathLike[str], names: Mapping[str, str], labels: Sequence[Label], nodes: Mapping[str, Node], **more: Any
) -> Housing:
    """A housing from named matrices in an OP4 file over freedoms `labels`, by pyNastran. `more`: see
    `from_matrices`."""
    found = _nastran("pyNastran.op4.op4").read_op4(os.fspath(path), log=_quiet())
    parts = {name: _named(path, found, wanted).data for name, wanted in names.items()}
    return from_matrices(parts, labels, nodes, source=str(path), **more)


def from_op2(
    path: str | os.PathLike[str], names: Mapping[str, str], labels: Sequence[Label], nodes: Mapping[str, Node], **more: Any
) -> Housing:
    """A housing from named matrices in an OP2 file over freedoms `labels`, by pyNastran. `more`: see
    `from_matrices`."""
    found = _nastran("pyNastran.op2.op2").read_op2(os.fspath(path), log=_quiet(), load_geometry=False).matrices
    parts = {name: _named(path, found, wanted).data for name, wanted in names.items()}
    return from_matrices(parts, labels, nodes, source=str(path), **more)


def from_matrix_market(
    files: Mapping[str, str | os.PathLike[str]], labels: Sequence[Label], nodes: Mapping[str, Node], **more: Any
) -> Housing:
    """A housing from Matrix Market files of M, K and optionally C over freedoms `labels`, by SciPy. `more`: see
    `from_matrices`."""
    scipy_io = optional("scipy.io", "scipy")
    try:
        found = {name: scipy_io.mmread(path) for name, path in files.items()}
    except (OSError, ValueError) as error:
        raise StructureError(f"{files}: not Matrix Market files: {error}; write them with scipy.io.mmwrite") from error
    return from_matrices(found, labels, nodes, source=", ".join(map(str, files.values())), **more)


def from_abaqus(
    files: Mapping[str, str | os.PathLike[str]], labels: Sequence[Label], nodes: Mapping[str, Node], **more: Any
) -> Housing:
    """A housing from `.mtx` files of M, K and optionally C, as Abaqus writes them with FORMAT=COORDINATE: lines of row,
    column, value.

    A single triangle is completed by symmetry. `more`: further arguments of `from_matrices`.
    """
    found = {}
    for name, path in files.items():
        try:
            lines = [line.replace(",", " ").split() for line in Path(path).read_text().splitlines()]
            entries = np.array([line for line in lines if line], dtype=float)
            rows, columns = (entries[:, side].astype(int) - 1 for side in (0, 1))
            matrix = np.zeros((len(labels), len(labels)))
            matrix[rows, columns] = entries[:, 2]
        except OSError as error:
            raise StructureError(f"{path}: cannot be read: {error.strerror}") from error
        except (ValueError, IndexError) as error:
            raise StructureError(f"{path}: is not a list of row, column, value over {len(labels)} freedoms: {error}") from error
        triangle = not np.triu(matrix, 1).any() or not np.tril(matrix, -1).any()
        found[name] = matrix + matrix.T - np.diag(np.diag(matrix)) if triangle else matrix
    return from_matrices(found, labels, nodes, source=", ".join(map(str, files.values())), **more)


def transfer(
    housing: Housing, frequency: npt.ArrayLike, force: str, *, loss_factor: float = 0.0
) -> dict[str, npt.NDArray[np.complex128]]:
    """Acceleration of every response point per newton on a freedom, such as `left x`, over frequencies [Hz]: (m/s²)/N.

    `−ω² r (K (1 + iη) + iω C − ω² M)⁻¹ f` for the housing without shafts, with the loss factor η. The product with a
    bearing force from `analyses.nvh.orders` is the share of this force in the acceleration.
    """
    load = housing.row(force).astype(complex)
    rows = np.array([housing.row(point) for point in housing.points]).reshape(len(housing.points), -1)
    omega = 2 * np.pi * np.atleast_1d(np.asarray(frequency, dtype=float))
    found = np.empty((len(rows), len(omega)), dtype=complex)
    for column, w in enumerate(omega):
        dynamic = housing.K * (1 + 1j * loss_factor) - w * w * housing.M
        if housing.C is not None:
            dynamic = dynamic + 1j * w * housing.C
        found[:, column] = -w * w * (rows @ np.linalg.solve(dynamic, load))
    return dict(zip(housing.points, found))


def write_uff(
    path: str | os.PathLike[str], housing: Housing, frequency: Sequence[float], forces: Sequence[str], *, loss_factor: float = 0.0
) -> None:
    """Writes the transfer functions from forces on these freedoms to all response points as UFF 58, by pyuff.

    `frequency` [Hz] is evenly spaced. Points and forces are numbered from 1 in their order, and named.
    """
    pyuff = optional("pyuff", "pyuff")
    spectrum = np.asarray(frequency, dtype=float)
    Path(path).unlink(missing_ok=True)
    file = pyuff.UFF(os.fspath(path))
    for reference, force in enumerate(forces, 1):
        for response, (point, values) in enumerate(transfer(housing, spectrum, force, loss_factor=loss_factor).items(), 1):
            dataset = pyuff.prepare_58(
                binary=0, id1=f"acceleration of {point} by force on {force}"[:80], func_type=4, rsp_ent_name=point[:10],
                rsp_node=response, rsp_dir=0, ref_ent_name=force[:10], ref_node=reference, ref_dir=0, ord_data_type=6,
                num_pts=len(spectrum), abscissa_spacing=1, abscissa_min=spectrum[0],
                abscissa_inc=spectrum[1] - spectrum[0] if len(spectrum) > 1 else 0.0,
                abscissa_spec_data_type=18, abscissa_axis_units_lab="Hz", ordinate_spec_data_type=12,
                ordinate_axis_units_lab="m/s^2", orddenom_spec_data_type=13, orddenom_axis_units_lab="N",
                x=spectrum, data=values,
            )  # fmt: skip
            file.write_sets(dataset, "add")


def _label(given: Sequence[Any]) -> Label:
    grid, component = given
    return int(grid), int(component)


def _named(path: Any, found: Mapping[str, Any], name: str) -> Any:
    if name not in found:
        raise StructureError(f"{path}: has no matrix `{name}`; it has {', '.join(found) or 'none'}")
    return found[name]


def _nastran(module: str) -> Any:
    try:
        return optional(module, "pyNastran 'numpy<2'")
    except AttributeError as error:
        raise ImportError("pyNastran 1.4 needs NumPy below 2; install both with `pip install pyNastran 'numpy<2'`") from error


def _quiet() -> Any:
    return _nastran("cpylog").SimpleLogger("error")


def _symmetric(name: str, matrix: Matrix, size: int) -> Vector:
    dense = np.asarray(matrix, dtype=float)
    if dense.shape != (size, size):
        raise StructureError(f"`{name}` has the shape {dense.shape}, but nodes and internal freedoms have {size} freedoms")
    if not np.isfinite(dense).all():
        raise StructureError(f"`{name}` has entries that are not finite; export it again")
    root = np.sqrt(np.abs(np.diag(dense)))
    root[root == 0.0] = 1.0
    apart = float(np.abs((dense - dense.T) / np.outer(root, root)).max())
    if apart > ROUND_OFF:
        raise StructureError(f"`{name}` is not symmetric: entries across the diagonal are up to {apart:.3g} of the diagonal apart")
    return np.asarray((dense + dense.T) / 2)


def _numbers(values: Any) -> str:
    return "[" + ", ".join(repr(float(value)) for value in values) + "]"


def _text(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _texts(texts: Sequence[str]) -> str:
    return "[" + ", ".join(map(_text, texts)) + "]"

"""Converts a structure of matrices to a modal file.

The file contains mass-normalised modes of K φ = ω² M φ and the projections of all other data on them
(docs/modal-files.md). Needs SciPy.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ._optional import optional
from .matrices import Contact, Matrices, Matrix, StructureError, Vector

# Up to this number of freedoms a dense solver is used; beyond, a sparse solver for the lowest modes.
DENSE = 1500

# A mode counts as a rigid motion if its elastic energy is below RIGID of the sum's terms, or its frequency below
# UNRESOLVED of the highest of the structure: an eigenvalue solver resolves squares of frequencies to 1e-16 of the
# highest.
RIGID = 1e-12
UNRESOLVED = 1e-8

# The program does not accept elastic modes below this fraction of the highest frequency of a file.
NEARLY_RIGID = 1e-5

# A freedom is at rest in a rigid motion below this fraction of the largest displacement, weighted by root masses.
AT_REST = 1e-9

# Round-off of a direction and of a matrix over the modes, relative to their summed terms. For a matrix also relative to
# the geometric mean of the two diagonal entries, and for rigid motions relative to the largest entry.
CANCELLED = 1e-12
COUPLED = 1e-10


@dataclass(frozen=True)
class Modes:
    """Mass-normalised modes."""

    frequency: Vector
    """Natural angular frequencies [rad/s], ascending; exactly 0 for rigid motions."""
    shapes: Vector
    """The modes, one column each over the freedoms [1/√kg]."""

    @classmethod
    def of(cls, structure: Matrices, count: int | None = None) -> Modes:
        """The lowest modes, `count` of them, or all.

        Small structures use a dense solver, large sparse ones shift-invert (ARPACK) with a negative shift, at
        which the matrix is positive definite despite rigid motions. Raises `StructureError` if K is not
        positive semidefinite, or M not positive definite.
        """
        size = structure.size
        wanted = size if count is None else count
        if not 1 <= wanted <= size:
            raise StructureError(f"{structure.source}: {wanted} modes are requested, but the structure has {size} freedoms; give 1 to {size}")
        sparse = hasattr(structure.K, "tocsc") or hasattr(structure.M, "tocsc")
        if sparse and size > DENSE and wanted < size - 1:
            shapes = _sparse(structure, wanted)
        else:
            shapes = _dense(structure, wanted)
        return cls(*_settled(structure, shapes))


def _dense(structure: Matrices, count: int) -> Vector:
    linalg = optional("scipy.linalg", "scipy")
    M, K = (_array(matrix) for matrix in (structure.M, structure.K))
    try:
        _, shapes = linalg.eigh((K + K.T) / 2, (M + M.T) / 2, subset_by_index=(0, count - 1))
    except np.linalg.LinAlgError as error:
        raise _indefinite(structure) from error
    return np.asarray(shapes)


def _sparse(structure: Matrices, count: int) -> Vector:
    linalg, sparse = optional("scipy.sparse.linalg", "scipy"), optional("scipy.sparse", "scipy")
    M, K = sparse.csc_matrix(structure.M), sparse.csc_matrix(structure.K)
    # Far below the elastic modes, and large enough that the shifted matrix is well conditioned.
    shift = -1e-8 * float(np.median(K.diagonal() / M.diagonal()))
    # A fixed start instead of a random one, so that the same matrices give the same file.
    start = np.cos(np.arange(structure.size) ** 2)
    try:
        _, shapes = linalg.eigsh(K, k=count, M=M, sigma=shift, v0=start)
    except (linalg.ArpackError, RuntimeError) as error:
        raise StructureError(
            f"{structure.source}: the search for {count} modes failed ({error}); ask for fewer modes, and check that M is positive definite"
        ) from error
    return np.asarray(shapes)


def _array(matrix: Matrix) -> Vector:
    return np.asarray(matrix.toarray() if hasattr(matrix, "toarray") else matrix, dtype=float)


def _indefinite(structure: Matrices) -> StructureError:
    return StructureError(
        f"{structure.source}: `M` is not positive definite; condense freedoms without mass before the export"
    )


def _settled(structure: Matrices, shapes: Vector) -> tuple[Vector, Vector]:
    """Frequencies from the energies of modes, rigid ones at 0, signs and norms settled."""
    M, K = structure.M, structure.K
    masses = np.einsum("im,im->m", shapes, M @ shapes)
    if not (np.isfinite(masses).all() and (masses > 0.0).all()):
        raise _indefinite(structure)
    shapes = shapes / np.sqrt(masses)
    energy = np.einsum("im,im->m", shapes, K @ shapes)
    terms = np.einsum("im,im->m", abs(shapes), abs(K) @ abs(shapes))
    # Both energy and terms are round-off for modes that move springs only by round-off.
    highest = max(float(energy.max()), float((K.diagonal() / M.diagonal()).max()))
    rigid = abs(energy) <= np.maximum(RIGID * terms, UNRESOLVED**2 * highest)
    if (energy[~rigid] < 0.0).any():
        raise StructureError(
            f"{structure.source}: `K` is not positive semidefinite: a mode has ω² = {energy.min():.4g} 1/s²; "
            "omit softening preloads, or put them into `Kc`"
        )
    frequency = np.where(rigid, 0.0, np.sqrt(abs(energy)))
    soft = frequency[~rigid & (frequency < NEARLY_RIGID * frequency.max())]
    if soft.size:
        raise StructureError(
            f"{structure.source}: a mode of {soft.min():.4g} rad/s beside one of {frequency.max():.4g} rad/s is too soft "
            f"to be distinguished from a rigid motion (below {NEARLY_RIGID:g} of the highest); write fewer modes, "
            "or remove the soft spring"
        )
    order = np.argsort(frequency, kind="stable")
    frequency, shapes = frequency[order], shapes[:, order]
    # Clear round-off of freedoms at rest in a rigid motion: a bearing with damping at round-off would split the motion.
    moved = np.sqrt(np.asarray(M.diagonal()))[:, np.newaxis] * abs(shapes)
    shapes = np.where((frequency == 0.0) & (moved <= AT_REST * moved.max(axis=0)), 0.0, shapes)
    # The sign of a mode is arbitrary; its largest entry is positive here.
    largest = abs(shapes).argmax(axis=0)
    return frequency, shapes * np.sign(shapes[largest, np.arange(len(frequency))])


def tables(structure: Matrices, modes: int | None = None, damping: float = 0.0) -> dict[str, Any]:
    """The modal file as a dictionary of tables.

    `modes` is the number of lowest modes, by default all. `damping` is a ratio of every elastic mode in addition to C.
    C becomes `damping`, which every kernel supports, if it does not couple modes or damp rigid motions; otherwise
    `damping_matrix`.
    """
    if not 0.0 <= damping < 1.0:
        raise StructureError(f"the damping ratio is {damping:g}; give a ratio of at least 0 and below 1")
    found = Modes.of(structure, modes)
    shapes = found.shapes

    def column(direction: Vector) -> list[float]:
        column = _clean(shapes.T @ direction, abs(shapes).T @ abs(np.asarray(direction)))
        return [float(entry) for entry in column]

    still = found.frequency == 0.0

    def over_modes(matrix: Matrix) -> Vector:
        projected = _clean(shapes.T @ (matrix @ shapes), abs(shapes).T @ (abs(matrix) @ abs(shapes)))
        # Entries of rigid motions that move dampers and springs only by round-off are round-off.
        weak = (abs(projected) <= CANCELLED * abs(projected).max()) & (still[:, np.newaxis] | still)
        return np.where(weak, 0.0, projected)

    ratios = np.where(found.frequency > 0.0, damping, 0.0)
    file: dict[str, Any] = {"teeth": structure.teeth}
    if structure.teeth_wheel is not None:
        file["teeth_wheel"] = structure.teeth_wheel
    file |= {"rated_force": structure.rated_force, "frequency": found.frequency.tolist()}
    coupled = {}
    if structure.C is not None:
        projected = over_modes(structure.C)
        own = _ratios(found.frequency, projected, abs(shapes).T @ (abs(structure.C) @ abs(shapes)))
        if own is None or (ratios + own >= 1.0).any():
            coupled["damping_matrix"] = projected.tolist()
        else:
            ratios = ratios + own
    if structure.G is not None:
        projected = over_modes(structure.G)
        coupled["gyroscopic_matrix"] = ((projected - projected.T) / 2).tolist()
    if structure.Kc is not None:
        coupled["stiffness_matrix"] = over_modes(structure.Kc).tolist()
    file["damping"] = ratios.tolist()
    file |= {name: column(direction) for name, direction in structure.directions.items()}
    file |= coupled
    kinds = {"contact": ("participation", "force"), "bearing": ("gain", "rate_gain")}
    for kind, (first, second) in kinds.items():
        parts: Mapping[str, Contact] = getattr(structure, f"{kind}s")
        file[kind] = [
            {"name": name, first: column(part.direction)}
            | ({second: column(part.second)} if part.second is not None else {})
            | dict(part.values)
            for name, part in parts.items()
        ]
    return file


def _clean(values: Vector, terms: Vector) -> Vector:
    """Sets sums whose terms cancel to round-off to 0, so that symmetries of a drive are preserved."""
    return np.where(abs(values) <= CANCELLED * terms, 0.0, values)


def _ratios(frequency: Vector, damping: Vector, terms: Vector) -> Vector | None:
    """The damping ratios in a matrix over the modes; None if it is not diagonal."""
    own = np.where(np.diag(damping) > CANCELLED * np.diag(terms), np.diag(damping), 0.0)
    apart = abs(damping - np.diag(np.diag(damping)))
    coupled = apart > COUPLED * np.sqrt(np.outer(own, own)) + CANCELLED * terms
    negative = np.diag(damping) < -CANCELLED * np.diag(terms)
    if coupled.any() or negative.any() or (own[frequency == 0.0] > 0.0).any():
        return None
    elastic = np.where(frequency > 0.0, frequency, 1.0)
    return np.where(frequency > 0.0, own / (2.0 * elastic), 0.0)


def write(
    structure: Matrices,
    path: str | os.PathLike[str],
    modes: int | None = None,
    damping: float = 0.0,
) -> dict[str, Any]:
    """Writes the modal file; arguments and return value are those of `tables`."""
    file = tables(structure, modes, damping)
    count = len(file["frequency"])
    head = [
        f"# {count} modes of {structure.size} freedoms, from {' '.join(structure.source.split())}, by gearatlas.modal_file.",
        "# SI: rad/s, 1/sqrt(kg). docs/modal-files.md describes the keys.",
    ]
    Path(path).write_text("\n".join(head + _lines(file)) + "\n", encoding="utf-8")
    return file


def _lines(file: Mapping[str, Any]) -> list[str]:
    """TOML: single values and lists first, then tables."""
    lines, behind = [], []
    for key, value in file.items():
        if key in ("contact", "bearing"):
            for table in value:
                behind += ["", f"[[{key}]]", *_lines(table)]
        else:
            lines.append(f"{key} = {_value(value)}")
    return lines + behind


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_value(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, np.ndarray | list | tuple):
        entries = [_value(entry) for entry in value]
        rows = bool(entries) and entries[0].startswith("[")
        return "[\n  " + ",\n  ".join(entries) + ",\n]" if rows else "[" + ", ".join(entries) + "]"
    if isinstance(value, bool | np.bool_):
        return str(bool(value)).lower()
    if isinstance(value, int | np.integer):
        return str(int(value))
    return repr(float(value))

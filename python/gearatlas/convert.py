"""Converts files of matrices to a modal file: `python -m gearatlas.convert drive.npz` or `drive.toml`.

    python -m gearatlas.convert drive.npz --modes 40 --out drive.modal.toml
    python -m gearatlas.convert drive.toml               # names Matrix Market files, gives directions by freedom

docs/modal-files.md lists the names of the arrays and keys.
"""

from __future__ import annotations

import argparse
import os
import sys
import tomllib
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ._optional import optional
from .matrices import DIRECTIONS, MATRICES, NUMBERS, Contact, Matrices, Matrix, StructureError, Vector
from .modal_file import write

# Names of the second direction of a contact and of a bearing.
SECOND = {"contact": "force", "bearing": "rate"}


def read(path: str | os.PathLike[str], gyroscopic_at: float | None = None) -> Matrices:
    """The structure in an `.npz` file, or in a `.toml` file that names Matrix Market files.

    `gyroscopic_at`: the pinion speed [rad/s] for which G is given; by default G is per rad/s. Raises `StructureError`,
    which names the file and the array.
    """
    source = Path(path)
    readers = {".npz": _npz, ".toml": _toml}
    if source.suffix not in readers:
        raise StructureError(f"{source}: is neither an .npz nor a .toml file; docs/modal-files.md describes both")
    try:
        found = readers[source.suffix](source)
    except OSError as error:
        raise StructureError(f"{source}: cannot be read: {error.strerror or error}") from error
    return _structure(found, str(source), gyroscopic_at)


def _npz(path: Path) -> dict[str, Any]:
    try:
        # Only arrays of numbers: unpickling could run code from the file.
        with np.load(path, allow_pickle=False) as arrays:
            found = {name: arrays[name] for name in arrays.files}
    except (ValueError, zipfile.BadZipFile, EOFError) as error:
        raise StructureError(f"{path}: is not an .npz file of numbers ({error}); write the file with numpy.savez") from error
    for name, array in found.items():
        if array.dtype.kind not in "iufc":
            raise StructureError(f"{path}: `{name}` contains {array.dtype}, not numbers; remove it, or convert it to float64")
    return found


def _toml(path: Path) -> dict[str, Any]:
    """Reads matrices from the named files; directions are tables of `freedom = value`, counted from 1."""
    try:
        text = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise StructureError(f"{path}: {error}") from error
    found: dict[str, Any] = {}
    for name in MATRICES:
        if name in text:
            found[name] = _market(path, name, text.pop(name))
    size = found["M"].shape[0] if "M" in found else 0

    def flat(name: str, value: Any) -> Iterator[tuple[str, Any]]:
        if isinstance(value, Mapping) and not all(key.isdecimal() for key in value):
            for key, entry in value.items():
                yield from flat(f"{name}.{key}", entry)
        elif isinstance(value, Mapping):
            yield name, _by_freedom(path, name, value, size)
        else:
            yield name, value

    for name, value in text.items():
        found.update(flat(name, value))
    return found


def _market(path: Path, name: str, file: Any) -> Matrix:
    if not isinstance(file, str):
        raise StructureError(f'{path}: `{name}` must name a file, such as {name} = "{name}.mtx"')
    matrix = path.parent / file
    try:
        return optional("scipy.io", "scipy").mmread(matrix)
    except OSError as error:
        raise StructureError(f"{path}: `{name}`: {matrix} cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise StructureError(f"{path}: `{name}`: {_no_market(matrix, error)}") from error


def _no_market(matrix: Path, error: ValueError) -> str:
    """The error for a file that is not a Matrix Market file, with advice on its conversion."""
    with matrix.open(encoding="utf-8", errors="replace") as lines:
        first = next((line for line in lines if line.strip()), "")
    fields = first.replace(",", " ").split()
    try:
        columns = len([float(field) for field in fields])
    except ValueError:
        columns = 0
    if columns == 5:
        return (
            f"{matrix} has lines of node, freedom, node, freedom, value, as Abaqus writes .mtx files, and is not a Matrix "
            "Market file; number the freedoms of the nodes, fill a scipy.sparse.coo_array with both triangles, and "
            "write it with scipy.io.mmwrite"
        )
    if columns == 3:
        return (
            f"{matrix} has lines of row, column, value without a header, as Abaqus writes .mtx files with "
            "FORMAT=COORDINATE, and is not a Matrix Market file; add two lines at the top, "
            "`%%MatrixMarket matrix coordinate real general` and `ROWS COLUMNS LINES` (`symmetric` instead of `general` if "
            "the lines contain one triangle)"
        )
    return f"{matrix} is not a Matrix Market file ({error}); write it with scipy.io.mmwrite"


def _by_freedom(path: Path, name: str, value: Mapping[str, Any], size: int) -> Vector:
    direction = np.zeros(size)
    for freedom, entry in value.items():
        place = int(freedom)
        if not 1 <= place <= size:
            raise StructureError(f"{path}: `{name}` has freedom {place}, but `M` has freedoms 1 to {size}; correct the number")
        if isinstance(entry, bool) or not isinstance(entry, int | float):
            raise StructureError(f"{path}: `{name}.{freedom}` is not a number; give a number")
        direction[place - 1] = entry
    return direction


def _structure(found: dict[str, Any], source: str, gyroscopic_at: float | None) -> Matrices:
    parts: dict[str, dict[str, Contact]] = {"contact": {}, "bearing": {}}
    split: dict[tuple[str, str], dict[str, Any]] = {}
    for name in list(found):
        kind, _, rest = name.partition(".")
        if kind in parts and rest:
            owner, _, key = rest.partition(".")
            split.setdefault((kind, owner), {})[key] = found.pop(name)
    for (kind, owner), values in split.items():
        parts[kind][owner] = _part(source, kind, owner, values)
    known = {*MATRICES, *NUMBERS, *DIRECTIONS}
    for name in found:
        if name not in known:
            raise StructureError(
                f"{source}: `{name}` is not a known name; known are {', '.join(sorted(known))}, "
                "contact.NAME, bearing.NAME"
            )
    for name in ("M", "K", "teeth", "rated_force"):
        if name not in found:
            raise StructureError(f"{source}: `{name}` is missing; docs/modal-files.md lists the required names")
    numbers = {name: _number(source, name, found[name]) for name in NUMBERS if name in found}
    matrices = {name: found[name] for name in MATRICES if name in found}
    if gyroscopic_at is not None:
        if "G" not in matrices or not (np.isfinite(gyroscopic_at) and gyroscopic_at != 0.0):
            raise StructureError(f"{source}: the speed of `G` must not be 0 and needs a matrix `G`; correct the speed, or add the matrix")
        matrices["G"] = matrices["G"] / gyroscopic_at
    return Matrices(
        **matrices,
        directions={name: np.asarray(found[name]) for name in DIRECTIONS if name in found},
        teeth=_whole(source, "teeth", numbers["teeth"]),
        teeth_wheel=_whole(source, "teeth_wheel", numbers["teeth_wheel"]) if "teeth_wheel" in numbers else None,
        rated_force=numbers["rated_force"],
        contacts=parts["contact"],
        bearings=parts["bearing"],
        source=source,
    )


def _part(source: str, kind: str, name: str, values: dict[str, Any]) -> Contact:
    # In a TOML file the direction is `contact.NAME.direction`, like the other keys.
    direction = values.pop("", values.pop("direction", None))
    if direction is None:
        raise StructureError(f"{source}: `{kind}.{name}` has no direction; give `{kind}.{name}` over the freedoms")
    second = values.pop(SECOND[kind], None)
    if kind == "bearing" and values:
        raise StructureError(f"{source}: `bearing.{name}.{next(iter(values))}` is unknown; a bearing can only have `rate`")
    plain = {
        key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in values.items()
    }
    return Contact(np.asarray(direction), None if second is None else np.asarray(second), plain)


def _number(source: str, name: str, value: Any) -> float:
    array = np.asarray(value)
    if array.size != 1 or array.dtype.kind not in "iuf" or not np.isfinite(array).all():
        raise StructureError(f"{source}: `{name}` must be one number")
    return float(array.reshape(()))


def _whole(source: str, name: str, value: float) -> int:
    if value != int(value):
        raise StructureError(f"{source}: `{name}` is {value:g}; give a whole number of teeth")
    return int(value)


def main(arguments: list[str] | None = None) -> int:
    """The command line: 0 if the file is written, 2 for bad input, 1 if it cannot be written."""
    parser = argparse.ArgumentParser(prog="python -m gearatlas.convert", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("structure", type=Path, help=".npz file of arrays, or .toml file that names .mtx files")
    parser.add_argument("--out", type=Path, help="write this modal file [default: NAME.modal.toml beside the structure]")
    parser.add_argument("--modes", type=int, help="write this many modes, the lowest first [default: all]")
    parser.add_argument("--damping", type=float, default=0.0, help="add this damping ratio to the elastic modes, in addition to C [default: 0]")
    parser.add_argument(
        "--gyroscopic-at", type=float, metavar="RAD/S", help="read G as given for this pinion speed [default: G is per rad/s]"
    )
    parser.add_argument("--overwrite", action="store_true", help="replace a file that already exists")
    given = parser.parse_args(arguments)
    out = given.out or given.structure.with_suffix(".modal.toml")
    if out.exists() and not given.overwrite:
        print(f"{out} already exists: choose another file with --out, or replace it with --overwrite", file=sys.stderr)
        return 2
    try:
        file = write(read(given.structure, given.gyroscopic_at), out, given.modes, given.damping)
    except (StructureError, ImportError) as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(f"{out}: cannot be written: {error.strerror}", file=sys.stderr)
        return 1
    frequency = np.array(file["frequency"]) / (2 * np.pi)
    rigid = int((frequency == 0.0).sum())
    elastic = frequency[rigid:]
    told = f", {elastic[0]:.6g} to {elastic[-1]:.6g} Hz" if elastic.size else ""
    print(f"{out}: {len(frequency)} modes, {rigid} of them rigid{told}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Writes result tables for NumPy, MATLAB or Excel: `python -m gearatlas.export results/flex80 --format mat`.

`atlas export` writes CSV and Arrow files.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ._errors import AtlasError
from ._html import titled
from ._optional import optional
from ._results import Results, open
from ._table import Table

# The largest integer up to which all integers are exact floating-point numbers.
_EXACT = 2**53
# Rows below the head, columns and characters in a cell of a worksheet of Excel.
_MOST_ROWS, _MOST_COLUMNS, _MOST_CHARACTERS = 1_048_575, 16_384, 32_767

_Tables = dict[str, tuple[Table, list[str]]]


def _chosen(results: Results, tables: Sequence[str], columns: Sequence[str]) -> _Tables:
    """The chosen tables with their chosen columns; tables without any are omitted."""
    unknown = [name for name in tables if name not in results.tables]
    if unknown:
        raise AtlasError(f"`{results.folder}` has no table `{unknown[0]}`; it has {', '.join(results.tables)}")
    found = {name: results.table(name) for name in tables or results.tables}
    for name in columns:
        if not any(name in table.columns for table in found.values()):
            raise AtlasError(f"no column `{name}` in {', '.join(found)}")
    kept = {name: (table, [c for c in table.columns if not columns or c in columns]) for name, table in found.items()}
    return {name: entry for name, entry in kept.items() if entry[1]}


def _exact(table: str, column: str, values: np.ndarray[Any, Any], format: str) -> None:
    if values.dtype.kind == "u" and values.size and values.max() > _EXACT:
        raise AtlasError(
            f"column `{column}` of table `{table}` has the whole number {values.max()}, which {format} cannot store "
            f"exactly: exclude it with --columns, or choose npz"
        )


def _column(table: Table, name: str) -> np.ndarray[Any, Any]:
    """A column without objects: missing texts become empty, missing truth values NaN. Other columns are unchanged."""
    values = table[name]
    if values.dtype != object:
        return values
    listed = values.tolist()
    if any(isinstance(value, bool) for value in listed):
        return np.array([np.nan if value is None else float(value) for value in listed])
    return np.array([text or "" for text in listed], dtype=str)


def _npz(chosen: _Tables, stem: str) -> dict[str, Callable[[Path], None]]:
    """A file per table, an array per column."""

    def write(path: Path, table: Table, columns: list[str]) -> None:
        arrays: dict[str, Any] = {name: _column(table, name) for name in columns}
        arrays |= {f"{name}_elements": np.array(table.elements(name)) for name in columns if table.elements(name)}
        arrays["column_names"] = np.array(columns)
        arrays["column_units"] = np.array([table.units[name] for name in columns])
        arrays["column_descriptions"] = np.array([table.descriptions[name] for name in columns])
        np.savez(path, **arrays)

    return {f"{name}.npz": partial(write, table=entry[0], columns=entry[1]) for name, entry in chosen.items()}


def _mat(chosen: _Tables, stem: str) -> dict[str, Callable[[Path], None]]:
    """One file, a struct per table, a column vector or matrix per column."""
    scipy = optional("scipy.io", "scipy")
    variables: dict[str, dict[str, Any]] = {"units": {}, "descriptions": {}, "elements": {}}
    for name, (table, columns) in chosen.items():
        own = variables[name] = {}
        for column in columns:
            values = _column(table, column)
            _exact(name, column, values, "MATLAB")
            if values.dtype.kind == "U":
                values = values.astype(object)
            elif values.dtype.kind in "fu":
                values = values.astype(float)
            own[column] = values.reshape(len(values), -1) if len(values) else values.reshape(0, 1)
        variables["units"][name] = {column: table.units[column] for column in columns}
        variables["descriptions"][name] = {column: table.descriptions[column] for column in columns}
        variables["elements"][name] = {column: np.array(table.elements(column), dtype=object) for column in columns}
    return {f"{stem}.mat": lambda path: scipy.savemat(path, variables, long_field_names=True, oned_as="column")}


def _flat(table: Table, columns: list[str]) -> dict[str, list[Any]]:
    """Columns by title, lists widened to a column per element; equal titles are numbered."""
    flat: dict[str, list[Any]] = {}
    for name in columns:
        values, names, unit = table[name], table.elements(name), table.units[name]
        wide = values.reshape(len(values), -1)
        for place in range(wide.shape[1]):
            plain = name
            if values.ndim > 1:
                named = len(names) == wide.shape[1]
                plain += "_" + (names[place].replace(" ", "_") if named else str(place + 1))
            title, count = titled(plain, unit), 1
            while title in flat:
                count += 1
                title = titled(f"{plain}_{count}", unit)
            flat[title] = [None if value != value else value for value in wide[:, place].tolist()]
    return flat


def _xlsx(chosen: _Tables, stem: str) -> dict[str, Callable[[Path], None]]:
    """One workbook, a worksheet per table and one that describes the columns."""
    openpyxl = optional("openpyxl", "openpyxl")
    for name, (table, columns) in chosen.items():
        width = sum(1 if (values := table[column]).ndim == 1 else values.shape[1] for column in columns)
        for found, most, what in ((table.rows, _MOST_ROWS, "rows"), (width, _MOST_COLUMNS, "columns")):
            if found > most:
                raise AtlasError(
                    f"table `{name}` has {found} {what}, but a worksheet of Excel holds at most {most}: "
                    f"choose columns with --columns, or choose npz"
                )
        for column in columns:
            values = table[column]
            _exact(name, column, values, "Excel")
            texts = [text for text in values.tolist() if isinstance(text, str)] if values.dtype == object else []
            if max(map(len, texts), default=0) > _MOST_CHARACTERS:
                raise AtlasError(f"column `{column}` of table `{name}` has a text too long for a cell of Excel: exclude it with --columns, or choose npz")

    def write(path: Path) -> None:
        book = openpyxl.Workbook(write_only=True)
        for name, (table, columns) in chosen.items():
            flat = _flat(table, columns)
            sheet = book.create_sheet(name)
            sheet.append(list(flat))
            for row in zip(*flat.values()):
                sheet.append(row)
        sheet = book.create_sheet("columns")
        sheet.append(["table", "column", "unit", "description"])
        for name, (table, columns) in chosen.items():
            for column in columns:
                sheet.append([name, column, table.units[column], table.descriptions[column]])
        book.save(path)

    return {f"{stem}.xlsx": write}


_FORMATS = {"npz": _npz, "mat": _mat, "xlsx": _xlsx}


def export(
    folder: str | os.PathLike[str],
    format: str,
    out: str | os.PathLike[str] | None = None,
    *,
    tables: Sequence[str] = (),
    columns: Sequence[str] = (),
    overwrite: bool = False,
) -> list[Path]:
    """Writes the tables of a folder of results as `npz` (NumPy), `mat` (MATLAB) or `xlsx` (Excel) into `out`, by default
    `export` in the folder, and returns the files. Files appear under their names only when complete."""
    results = open(folder)
    place = Path(out) if out is not None else results.folder / "export"
    chosen = _chosen(results, tables, columns)
    files = _FORMATS[format](chosen, results.folder.resolve().name)
    for name in files:
        if (place / name).exists() and not overwrite:
            raise AtlasError(f"`{place / name}` already exists: choose another folder, or replace the file with overwrite")
    place.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(dir=place) as unfinished:
        for name, write in files.items():
            write(Path(unfinished) / name)
            (Path(unfinished) / name).replace(place / name)
    return [place / name for name in files]


def _names(text: str) -> list[str]:
    return text.split(",")


def _main() -> None:
    parser = argparse.ArgumentParser(prog="python -m gearatlas.export", description=__doc__)
    parser.add_argument("folder", help="folder that `atlas run`, `atlas follow` or `atlas trace` wrote")
    parser.add_argument("--format", choices=list(_FORMATS), required=True, help="write files of this format")
    parser.add_argument("--tables", metavar="TABLE,...", help="write only these tables [default: all]", type=_names, default=[])
    of_columns = "write only these columns, of all tables that have them [default: all]"
    parser.add_argument("--columns", metavar="COLUMN,...", help=of_columns, type=_names, default=[])
    parser.add_argument("--out", metavar="DIR", help="write the files to this folder [default: `export` in the folder]")
    parser.add_argument("--overwrite", action="store_true", help="replace files that already exist")
    given = vars(parser.parse_args())
    try:
        for file in export(given.pop("folder"), given.pop("format"), given.pop("out"), **given):
            print(file)
    except AtlasError as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    _main()

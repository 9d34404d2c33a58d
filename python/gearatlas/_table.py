"""Tables as Arrow, NumPy, pandas and polars, with their units."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _gearatlas
from ._optional import optional

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow

# Units of result files that a parser of units does not read.
_AS_PINT = {"": "", "1": "", "mesh cycles": "", "1/cycle": "", "half gaps": ""}


class Table:
    """A table; `table["speed"]` is a column as a NumPy array.

    Libraries that accept Arrow accept a table without copying: `polars.DataFrame(table)`, `pyarrow.table(table)`,
    `duckdb.sql("select * from table")`.
    """

    def __init__(self, inner: _gearatlas.Table) -> None:
        self._inner = inner

    def __arrow_c_schema__(self) -> object:
        return self._inner.__arrow_c_schema__()

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        return self._inner.__arrow_c_stream__(requested_schema)

    @property
    def columns(self) -> list[str]:
        """Names of the columns, in order."""
        return self._inner.columns

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self._inner)

    @property
    def units(self) -> dict[str, str]:
        """SI unit of every column; `1` if dimensionless, empty for texts and truth values."""
        return {name: self._inner.told(name).get("unit", "") for name in self.columns}

    @property
    def descriptions(self) -> dict[str, str]:
        """Description of every column."""
        return {name: self._inner.told(name).get("description", "") for name in self.columns}

    @property
    def metadata(self) -> dict[str, str]:
        """Metadata of the table's file."""
        return self._inner.metadata

    def elements(self, name: str) -> list[str]:
        """Names of the elements of a column's lists; empty if they are only numbered."""
        names: list[str] = json.loads(self._inner.told(name).get("elements", "[]"))
        return names

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """A column. Missing numbers are NaN; whole numbers stay whole if none is missing. Lists are rows of a matrix,
        filled with NaN. Texts are objects."""
        column = self._inner.column(name)
        if isinstance(column, list):
            return np.array(column, dtype=object)
        return column

    def __repr__(self) -> str:
        return f"<gearatlas.Table of {self.rows} rows: {', '.join(self.columns)}>"

    def to_numpy(self) -> dict[str, npt.NDArray[Any]]:
        """All columns as arrays."""
        return {name: self[name] for name in self.columns}

    def to_dicts(self) -> list[dict[str, Any]]:
        """The rows as dictionaries; a missing value is None, and lists are as in `table[name]`."""
        columns = {name: self[name].tolist() for name in self.columns}
        rows = (dict(zip(columns, row)) for row in zip(*columns.values()))
        return [{name: None if value != value else value for name, value in row.items()} for row in rows]

    def to_pyarrow(self) -> pyarrow.Table:
        """As a pyarrow table, without copying."""
        table: pyarrow.Table = optional("pyarrow", "pyarrow").table(self)
        return table

    def to_pandas(self) -> pandas.DataFrame:
        """As a pandas data frame (needs pyarrow). `frame.attrs["units"]` and `["descriptions"]` describe its columns."""
        optional("pandas", "pandas pyarrow")
        frame = self.to_pyarrow().to_pandas()
        frame.attrs["units"] = self.units
        frame.attrs["descriptions"] = self.descriptions
        return frame

    def to_polars(self) -> polars.DataFrame:
        """As a polars data frame, without copying."""
        frame: polars.DataFrame = optional("polars", "polars").DataFrame(self)
        return frame

    def quantity(self, name: str) -> Any:
        """A column as a pint quantity."""
        pint = optional("pint", "pint")
        unit = self.units[name]
        unit = _AS_PINT.get(unit, unit.replace("sqrt(kg)", "kg**0.5").replace(" ", " * "))
        return pint.Quantity(self[name], unit)

    def on_grid(self, name: str, direction: str | None = None) -> npt.NDArray[Any]:
        """A column over the axes of the grid, one dimension per axis, in the order of `metadata["axes"]` with ascending
        values. Missing points are NaN (or None). For a sweep in both directions (`grid.order = "both"`), choose
        `direction="up"` or `"down"`."""
        axes: list[str] = json.loads(self.metadata["axes"])
        if "samples" in self.metadata:
            raise ValueError("samples of distributions are no grid; use gearatlas.quantiles, or the columns themselves")
        values = self[name]
        if values.ndim != 1:
            raise ValueError(f"column `{name}` contains lists; choose a column of single values")
        ways = self["direction"] if "direction" in self.columns else np.full(self.rows, None)
        known = sorted({way for way in ways if way is not None})
        if direction is None and len(known) > 1:
            raise ValueError("the sweep has both directions; choose direction='up' or direction='down'")
        if direction is not None and direction not in known:
            raise ValueError(f"no sweep has the direction {direction!r}; the directions are {known or 'none'}")
        kept = (ways == direction) if direction is not None else np.full(self.rows, True)
        places = [np.unique(self[axis], return_inverse=True) for axis in axes]
        kind: Any = float if values.dtype.kind in "fiu" else object
        out = np.full([len(found) for found, _ in places], np.nan if kind is float else None, kind)
        out[tuple(place[kept] for _, place in places)] = values[kept]
        return out

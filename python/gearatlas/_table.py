"""Tables as Arrow, NumPy, pandas, polars and xarray, with their units."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt
from numpy.lib.recfunctions import structured_to_unstructured

from . import _gearatlas
from ._html import html_table, titled
from ._layout import Layout, dataset
from ._optional import optional

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow
    import xarray

# Units of result files that pint cannot parse.
_AS_PINT = {"": "", "1": "", "mesh cycles": "", "1/cycle": "", "half gaps": ""}

_SHOWN = (8, 16)
"""Largest numbers of rows and columns in a notebook."""

Rows = slice | Sequence[int] | Sequence[bool] | npt.NDArray[Any]


class Table:
    """A table: a sequence of rows with named columns, like a structured array of NumPy.

    >>> import gearatlas
    >>> table = gearatlas.load("manifests/quickstart.toml").grid
    >>> len(table), table.columns
    (12, ['point_id', 'load', 'speed'])
    >>> table["speed"][:4].round(1)
    array([ 628.3,  837.8, 1047.2, 1256.6])
    >>> table[5]["load"], "load" in table, table[5] in table
    (0.2, True, True)
    >>> len(table[table["load"] > 0.15]), sum(row["load"] > 0.15 for row in table)
    (8, 8)
    >>> import numpy
    >>> numpy.asarray(table)["load"].shape, numpy.asarray(table[["load", "speed"]], float).shape
    ((12,), (12, 2))

    * `table["speed"]` is a column. A name in brackets or a number from 1 selects an element of a column of lists:
      `table["harmonics[1]"]`, `table["contact_force[drive flank]"]`.
    * `table[5]` is a row, a dictionary, and iteration gives such rows.
    * `table[2:5]`, `table[mask]` and `table[numbers]` are tables of some rows, `table[["load", "speed"]]` of some columns.
    * `name in table` asks for a column, `row in table` for a row.
    * `numpy.asarray(table)` is a structured array. With a type, `numpy.asarray(table, float)` has a column for each number.

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

    def unit(self, name: str) -> str:
        """SI unit of a column, or of an element of its lists."""
        return self._inner.told(self._split(name)[0]).get("unit", "")

    def __len__(self) -> int:
        return self.rows

    def __iter__(self) -> Iterator[dict[str, Any]]:
        names = self.columns
        cells = (map(_known, self[name].tolist()) for name in names)
        return (dict(zip(names, row)) for row in zip(*cells))

    def __contains__(self, key: object) -> bool:
        return key in self.columns if isinstance(key, str) else any(key == row for row in self)

    @overload
    def __getitem__(self, key: str) -> npt.NDArray[Any]: ...
    @overload
    def __getitem__(self, key: int) -> dict[str, Any]: ...
    @overload
    def __getitem__(self, key: Rows | list[str]) -> Table: ...
    def __getitem__(self, key: Any) -> Any:
        """A column: missing numbers are NaN; whole numbers stay whole if none is missing. Lists are rows of a matrix,
        filled with NaN. Texts are objects. In a row a missing value is None, and lists have their own length."""
        if isinstance(key, str):
            return self._column(key)
        if isinstance(key, (int, np.integer)):
            if not -len(self) <= key < len(self):
                raise IndexError(f"there is no row {key}: the table has {len(self)} rows, counted from 0")
            return next(iter(self[[int(key) % len(self)]]))
        if isinstance(key, (list, tuple)) and key and all(isinstance(name, str) for name in key):
            return Table(self._inner.selected(list(key)))
        rows = np.arange(len(self), dtype=np.uint64)[key]
        if rows.ndim != 1:
            raise IndexError("the rows of a table have one index: a number, a slice, a mask or numbers")
        return Table(self._inner.taken(rows))

    def _column(self, name: str) -> npt.NDArray[Any]:
        base, element = self._split(name)
        column = self._inner.column(base)
        values = np.array(column, dtype=object) if isinstance(column, list) else column
        return values if element is None else values[:, element]

    def _split(self, name: str) -> tuple[str, int | None]:
        """The column that a name means, and the position of an element of its lists."""
        base, bracket, element = name.removesuffix("]").rpartition("[")
        if name in self.columns or not bracket or base not in self.columns:
            return name, None
        column = self._inner.column(base)
        width = 0 if isinstance(column, list) or column.ndim == 1 else column.shape[1]
        numbers = [str(number) for number in range(1, width + 1)]
        for known in (self.elements(base), numbers):
            if element in known:
                return base, known.index(element)
        raise KeyError(name)

    def single(self, name: str) -> npt.NDArray[Any]:
        """A column with one value per row, (rows,). Raises `ValueError` if it has lists."""
        values = self[name]
        if values.ndim != 1:
            raise ValueError(f"column `{name}` contains lists; choose an element of them, `{name}[1]` to `{name}[{values.shape[1]}]`")
        return values

    def stderr(self, name: str) -> npt.NDArray[np.float64] | None:
        """Standard errors of a column or element, (rows,), NaN for missing ones; None if the table has none."""
        base, bracket, element = name.partition("[")
        partner = ("lambda_stderr" if base == "lambda_max" else f"{base}_stderr") + bracket + element
        # The lists of errors are empty if no point has any.
        try:
            return np.asarray(self[partner], float)
        except KeyError:
            return None

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        if copy is False:
            raise ValueError("a table becomes an array by copying; leave out copy=False")
        columns = self.to_numpy()
        kinds = [(name, values.dtype, values.shape[1:]) for name, values in columns.items()]
        array: npt.NDArray[Any] = np.empty(len(self), np.dtype(kinds))
        for name, values in columns.items():
            array[name] = values
        if dtype is None or np.dtype(dtype).names is not None:
            return array if dtype is None else array.astype(dtype)
        return structured_to_unstructured(array, np.dtype(dtype))

    def __repr__(self) -> str:
        return f"<gearatlas.Table of {self.rows} rows: {', '.join(self.columns)}>"

    def _repr_html_(self) -> str:
        """The first rows, for notebooks, of the columns that have values."""
        most_rows, most_columns = _SHOWN
        rows = list(self[:most_rows])
        used = [name for name in self.columns if any(row[name] is not None for row in rows)] or self.columns
        shown = used[:most_columns]
        head = [titled(name, self.unit(name)) for name in shown]
        note = f"{self.rows} rows, {len(self.columns)} columns"
        if len(rows) < self.rows or len(shown) < len(self.columns):
            note += f"; shown are {len(rows)} rows and {len(shown)} columns"
        return html_table(head, [[row[name] for name in shown] for row in rows], note)

    def to_numpy(self) -> dict[str, npt.NDArray[Any]]:
        """All columns as arrays."""
        return {name: self[name] for name in self.columns}

    def to_dicts(self) -> list[dict[str, Any]]:
        """The rows as dictionaries; a missing value is None."""
        return list(self)

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

    def to_xarray(self, points: Table | None = None) -> xarray.Dataset:
        """As a dataset of xarray with one dimension per axis of the grid, with units and descriptions as attributes.

        >>> import gearatlas
        >>> gearatlas.load("manifests/quickstart.toml").grid.to_xarray()["point_id"].dims
        ('load', 'speed')

        Tied axes share a dimension. So do axes that are distributions, under the name `sample`. A sweep in both directions
        has a dimension `direction`. Branches of `follow` have the dimension `branch`, and curves have `curve`. Rows with the
        same values of all axes are counted along `row`. Elements of lists have a dimension such as `contact` or
        `harmonics_number`. A missing number is NaN.

        `points` is the table of points of the same results. It gives the axes of a table with only `point_id`;
        `Results.to_xarray` does this.
        """
        return dataset(self, points)

    def plot(self, column: str | None = None, **options: Any) -> Any:
        """Draws a column with Matplotlib; `Results.plot` lists the options."""
        from ._plot import plot

        return plot(self, None, column, **options)

    def quantity(self, name: str) -> Any:
        """A column as a pint quantity."""
        pint = optional("pint", "pint")
        unit = self.unit(name)
        unit = _AS_PINT.get(unit, unit.replace("sqrt(kg)", "kg**0.5").replace(" ", " * "))
        return pint.Quantity(self[name], unit)

    def on_grid(self, name: str, direction: str | None = None) -> npt.NDArray[Any]:
        """A column over the axes of the grid, one dimension per axis, in the order of `metadata["axes"]` with ascending
        values. Missing points are NaN (or None). For a sweep in both directions (`grid.order = "both"`), choose
        `direction="up"` or `"down"`."""
        axes: list[str] = json.loads(self.metadata["axes"])
        if "samples" in self.metadata:
            raise ValueError("samples of distributions are no grid; use gearatlas.quantiles, or the columns themselves")
        ways = self["direction"] if "direction" in self.columns else np.full(self.rows, None)
        known = sorted({way for way in ways if way is not None})
        if direction is None and len(known) > 1:
            raise ValueError("the sweep has both directions; choose direction='up' or direction='down'")
        if direction is not None and direction not in known:
            raise ValueError(f"no sweep has the direction {direction!r}; the directions are {known or 'none'}")
        kept = self if direction is None else self[ways == direction]
        values = kept.single(name)
        layout = Layout.along([{axis: kept[axis]} for axis in axes], len(kept))
        return layout.array(values.astype(float) if values.dtype.kind in "iu" else values)


def _known(value: Any) -> Any:
    """A value of a row: None for NaN. A list ends with its last value, and is None without any."""
    if isinstance(value, list):
        known = [_known(own) for own in value]
        while known and known[-1] is None:
            known.pop()
        return known or None
    return None if value != value else value

"""Positions of the rows of a table in arrays with one dimension per axis of the grid, and such arrays for xarray."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._optional import optional

if TYPE_CHECKING:
    import xarray

    from ._table import Table

Array = npt.NDArray[Any]

ROW = "row"
"""The dimension that counts rows with the same values of all axes."""


@dataclass(frozen=True)
class Layout:
    """Positions of rows in arrays."""

    dims: dict[str, Array]
    """The dimensions, slowest first, with the ascending values of their axes."""
    places: tuple[Array, ...]
    """Position of every row along each dimension, (rows,) each."""
    beside: dict[str, tuple[str, Array]]
    """Other axes: the dimension along which they change, and their values."""

    @classmethod
    def of(cls, table: Table, points: Table | None = None) -> Layout:
        """The layout over the axes of the grid.

        Tied axes share a dimension, and so do the axes of distributions (`sample`). A sweep in both directions has a
        dimension `direction`. Branches and curves have a dimension of this name. Rows that agree in all of these are counted
        along `row`. A table without axes needs the table `points` of the same results for them.
        """
        source = points if points is not None and "axes" not in table.metadata and "point_id" in table.columns else table
        groups = _groups(source)
        rows: Any = slice(None)
        if source is not table:
            numbers = source["point_id"]
            order = np.argsort(numbers)
            rows = order[np.searchsorted(numbers[order], table["point_id"])]
        return cls.along([{name: source[name][rows] for name in group} for group in groups], len(table))

    @classmethod
    def along(cls, groups: Sequence[dict[str, Array]], rows: int) -> Layout:
        """The layout with one dimension per group of columns, (rows,) each, named after the first of them."""
        dims: dict[str, Array] = {}
        beside: dict[str, tuple[str, Array]] = {}
        places: list[Array] = []
        for group in groups:
            columns = list(group.values())
            keys = columns[0] if len(columns) == 1 else np.column_stack(columns)
            _, first, place = np.unique(keys, return_index=True, return_inverse=True, axis=0 if keys.ndim == 2 else None)
            dim, *others = group
            dims[dim] = group[dim][first]
            beside |= {name: (dim, group[name][first]) for name in others}
            places.append(place.reshape(-1))
        shape = [len(values) for values in dims.values()]
        flat = np.ravel_multi_index(places, shape) if places else np.zeros(rows, int)
        number = _count_within(flat)
        if not places or number.any():
            dims[ROW] = np.arange(number.max(initial=-1) + 1)
            places.append(number)
        return cls(dims, tuple(places), beside)

    def array(self, values: Array) -> Array:
        """Values of the rows, (rows, ...), as an array over the dimensions. Elements without a row are NaN or None."""
        places = [len(own) for own in self.dims.values()]
        shape = (*places, *values.shape[1:])
        if len(values) == math.prod(places):
            out: Array = np.empty(shape, values.dtype)
        else:
            out = np.full(shape, np.nan if values.dtype.kind in "fiu" else None)
        out[self.places] = values
        return out

    def values(self, name: str) -> Array:
        """The value of an axis in every row, (rows,)."""
        dim, values = self.beside.get(name, (name, self.dims.get(name)))
        if values is None:
            raise KeyError(name)
        return values[self.places[list(self.dims).index(dim)]]


def _groups(table: Table) -> list[list[str]]:
    """The axes that share a dimension."""
    told = table.metadata
    if "over" in told:
        return [[name] for name in table.columns[:1]]
    axes: list[str] = json.loads(told.get("axes", "[]"))
    shared: list[list[str]] = json.loads(told.get("tied", "[]"))
    if "samples" in told:
        shared.insert(0, ["sample", *json.loads(told["samples"])["axes"]])
    ways = set(table["direction"]) if "direction" in table.columns and axes else set()
    groups = [["direction"]] if len(ways) > 1 else []
    for axis in axes:
        group = next((group for group in shared if axis in group), [axis])
        if group not in groups:
            groups.append(group)
    return groups


def _count_within(keys: Array) -> Array:
    """The number of earlier elements with the same key, (n,)."""
    order = np.argsort(keys, kind="stable")
    begins = np.r_[True, np.diff(keys[order]) != 0][: len(keys)]
    starts = np.maximum.accumulate(np.where(begins, np.arange(len(keys)), 0)) if len(keys) else keys
    number = np.empty(len(keys), int)
    number[order] = np.arange(len(keys)) - starts
    return number


def dataset(table: Table, points: Table | None) -> xarray.Dataset:
    """The columns of a table over the dimensions of its layout."""
    made = optional("xarray", "xarray")
    layout = Layout.of(table, points)
    units, descriptions = dict(table.units), table.descriptions
    if points is not None:
        units = {**points.units, **units}

    def attributes(name: str) -> dict[str, str]:
        told = {"units": units.get(name, ""), "description": descriptions.get(name, "")}
        return {key: text for key, text in told.items() if text}

    coordinates: dict[str, Any] = {name: (name, values, attributes(name)) for name, values in layout.dims.items()}
    coordinates |= {name: (dim, values, attributes(name)) for name, (dim, values) in layout.beside.items()}
    labels: dict[str, list[Any]] = {}
    variables: dict[str, Any] = {}
    for name in table.columns:
        values = table[name]
        if name in coordinates or values.shape[1:] == (0,):
            continue
        dims = list(layout.dims)
        if values.ndim == 2:
            dims.append(_along_elements(table, name, values.shape[1], labels))
        variables[name] = (dims, layout.array(values), attributes(name))
    coordinates |= {name: (name, own) for name, own in labels.items()}
    kept = {key: text for key, text in table.metadata.items() if key not in ("units", "descriptions", "axes")}
    found: xarray.Dataset = made.Dataset(variables, coordinates, kept)
    axes = json.loads(table.metadata.get("axes", "[]"))
    return found.set_coords([name for name in axes if name in variables])


def _along_elements(table: Table, name: str, width: int, labels: dict[str, list[Any]]) -> str:
    """The dimension of the elements of a list: `contact` of all `contact_...` columns with the same names, or
    `harmonics_number` of `harmonics` and `harmonics_stderr`. The function adds its labels to `labels`."""
    names: list[Any] = table.elements(name)
    own = names or list(range(1, width + 1))
    base = name.removesuffix("_stderr").removesuffix("_spread")
    for dim in [name.partition("_")[0], f"{base}_name"] if names else [f"{base}_number", f"{name}_number"]:
        if dim not in table.columns and labels.setdefault(dim, own) == own:
            return dim
    raise ValueError(f"column `{name}` has other elements than its neighbours")

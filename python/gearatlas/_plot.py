"""Pictures of tables by Matplotlib: curves over one axis of the grid, maps over two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _gearatlas
from ._errors import AtlasError
from ._html import titled
from ._layout import ROW, Layout
from ._measured import Quantity
from ._optional import optional

if TYPE_CHECKING:
    from ._table import Table

Array = npt.NDArray[Any]

_FIRST = ("lambda_max", "deflection_rms", "deflection")
"""Candidates for the default column; the first with values is drawn."""

_MOST_IN_LEGEND = 12


def plot(
    table: Table,
    points: Table | None,
    column: str | None = None,
    *,
    over: str | Sequence[str] | None = None,
    at: Mapping[str, Any] | None = None,
    units: Mapping[str, str] | None = None,
    axes: Any = None,
    **style: Any,
) -> Any:
    """Draws a column of a table, as `Results.plot` describes."""
    picture = _Picture(table, points, units or {})
    column = column or picture.default()
    fixed = picture.fix(at or {})
    across = picture.across(over)
    if axes is None:
        axes = optional("matplotlib.pyplot", "matplotlib").subplots()[1]
    if len(across) == 2:
        picture.map(axes, across, column, style)
    elif "over" in table.metadata and across == [table.metadata["over"]]:
        picture.branches(axes, across[0], column, style)
    else:
        picture.curves(axes, across[0], column, style)
    axes.set_title(fixed)
    return axes


class _Picture:
    """The rows of a table that a picture shows, with their axes."""

    def __init__(self, table: Table, points: Table | None, units: Mapping[str, str]) -> None:
        self.table = table
        self.layout = Layout.of(table, points)
        self.tables = [table] if points is None else [table, points]
        self.units = units
        self.kept = np.full(len(table), True)
        if not len(table):
            raise AtlasError("the table has no rows to draw")

    def default(self) -> str:
        """The column to draw if none is named."""
        for name in _FIRST:
            if name in self.table.columns and np.isfinite(self.table[name]).any():
                return name
        raise AtlasError(f"name the column to draw; the columns are {', '.join(self.table.columns)}")

    def si(self, name: str) -> Array:
        """A column, or an axis of the grid, of all rows in SI, (rows,)."""
        try:
            return self.table.single(name)
        except KeyError:
            return self.layout.values(name)

    def unit(self, name: str) -> str:
        """SI unit of a column or an axis; empty without one."""
        for table in self.tables:
            try:
                return table.unit(name)
            except KeyError:
                continue
        return ""

    def factor(self, name: str) -> float:
        """Number of drawn units in one SI unit."""
        wanted = self.units.get(name)
        factor = 1.0 if wanted is None else _gearatlas.conversion(self.unit(name), wanted)
        if factor is None:
            raise AtlasError(f"`{wanted}` is not a unit of {name}, whose SI unit is {self.unit(name)}")
        return factor

    def shown(self, name: str) -> Array:
        """The values of the kept rows, in the drawn unit; None becomes an empty text."""
        values = self.si(name)[self.kept]
        if values.dtype.kind in "OU":
            return np.array(["" if value is None else str(value) for value in values])
        return np.asarray(values * self.factor(name))

    def label(self, name: str) -> str:
        return titled(name, self.units.get(name, self.unit(name)))

    def fix(self, at: Mapping[str, Any]) -> str:
        """Keeps the rows whose axis values are nearest to the requested ones, and describes these values."""
        told = []
        for name, value in at.items():
            own = self.si(name)
            nearest: Any = value
            if not isinstance(value, str):
                wanted = Quantity.of(name, value).in_si(self.unit(name))
                nearest = own[self.kept][np.argmin(np.abs(own[self.kept] - wanted))]
            self.kept &= own == nearest
            if not self.kept.any():
                raise AtlasError(f"no row has {name} = {value}; the values are {', '.join(map(str, np.unique(own)))}")
            shown = nearest if isinstance(nearest, str) else f"{nearest * self.factor(name):.4g} {self.units.get(name, self.unit(name))}"
            told.append(f"{name} = {shown.removesuffix(' 1')}")
        return ", ".join(told)

    def varied(self) -> list[str]:
        """The axes with several values in the kept rows."""
        return [name for name in self.layout.dims if name != ROW and len(np.unique(self.layout.values(name)[self.kept])) > 1]

    def across(self, over: str | Sequence[str] | None) -> list[str]:
        """One or two axes of the picture; by default those that vary."""
        if over is not None:
            return [over] if isinstance(over, str) else list(over)
        if "over" in self.table.metadata:
            return [self.table.metadata["over"]]
        varied = [name for name in self.varied() if name != "direction"]
        if not varied and "time" in self.table.columns:
            return ["time"]
        if len(varied) in (1, 2) and not (len(varied) == 2 and ROW in self.layout.dims):
            return varied
        if not varied:
            raise AtlasError("the results have a single operating point; name a column as over=")
        raise AtlasError(f"{', '.join(varied)} vary; fix some of them by at={{'{varied[0]}': ...}}, or name one or two as over=")

    def map(self, axes: Any, across: Sequence[str], column: str, style: Mapping[str, Any]) -> None:
        """Colours over two axes, the first one vertical."""
        others = [name for name in self.varied() if name not in across]
        if others:
            raise AtlasError(f"{', '.join(others)} vary too; fix them by at={{'{others[0]}': ...}}")
        up, right, values = (self.shown(name) for name in [*across, column])
        classes: list[str] = []
        if values.dtype.kind == "U":
            classes, values = (found for found in np.unique(values, return_inverse=True))  # type: ignore[assignment]
        colours = optional("matplotlib", "matplotlib").colormaps
        if len(classes):
            style = {"cmap": colours["tab10"].resampled(10), "vmin": -0.5, "vmax": 9.5, **style}
        plane = Layout.along([{across[0]: up}, {across[1]: right}], len(values))
        if any("refined" in table.metadata for table in self.tables):
            drawn = axes.scatter(right, up, c=values, **{"s": 6, **style})
        else:
            rows, columns = plane.dims[across[0]], plane.dims[across[1]]
            drawn = axes.pcolormesh(columns, rows, plane.array(values.astype(float)), **{"shading": "nearest", **style})
        bar = axes.figure.colorbar(drawn, ax=axes, label=self.label(column))
        if len(classes):
            bar.set_ticks(range(len(classes)), labels=classes)
            bar.ax.set_ylim(-0.5, len(classes) - 0.5)
        axes.set(xlabel=self.label(across[1]), ylabel=self.label(across[0]))

    def curves(self, axes: Any, over: str, column: str, style: Mapping[str, Any]) -> None:
        """One curve per combination of the other varying axes, with standard errors; dots if several rows share a
        point."""
        right, up = self.shown(over), self.shown(column)
        errors = self.table.stderr(column)
        others = [name for name in self.varied() if name != over]
        groups = Layout.along([{name: self.shown(name) for name in others}], len(right)) if others else None
        group = groups.places[0] if groups else np.zeros(len(right), int)
        dots = ROW in self.layout.dims and over != "time"
        for number in range(group.max() + 1):
            rows = np.flatnonzero(group == number)
            rows = rows[np.argsort(right[rows], kind="stable")]
            label = ", ".join(f"{name} = {_short(self.shown(name)[rows[0]])}" for name in others) or None
            if dots or up.dtype.kind == "U":
                axes.plot(right[rows], up[rows], **{"ls": "", "marker": ".", "ms": 2 if dots else 6, "label": label, **style})
                continue
            bars = None if errors is None or over == "time" else (errors[self.kept] * self.factor(column))[rows]
            bars = None if bars is None or not (bars > 0).any() else bars
            axes.errorbar(right[rows], up[rows], bars, **{"marker": "." if len(rows) < 50 else "", "capsize": 2, "label": label, **style})
        axes.set(xlabel=self.label(over), ylabel=self.label(column))
        if others and group.max() < _MOST_IN_LEGEND:
            axes.legend()

    def branches(self, axes: Any, over: str, column: str, style: Mapping[str, Any]) -> None:
        """One line per branch, dashed for unstable orbits."""
        right, up = self.shown(over), self.shown(column)
        branch = self.layout.places[0][self.kept]
        stable = self.table["stable"][self.kept].astype(bool)
        for number in np.unique(branch):
            rows = branch == number
            colour = f"C{number % 10}"
            for kept, line in ((stable, "-"), (~stable, "--")):
                # The orbits at both ends of a change are drawn with it.
                part = np.where(kept[rows] | np.roll(kept[rows], 1) & (line == "--"), up[rows], np.nan)
                axes.plot(right[rows], part, **{"ls": line, "color": colour, **style})
        axes.set(xlabel=self.label(over), ylabel=self.label(column))


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, (float, np.floating)) else str(value)

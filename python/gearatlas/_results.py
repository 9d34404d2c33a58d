"""Folders of results: their tables and the records of their runs."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from . import _gearatlas
from ._errors import AtlasError
from ._html import html_table
from ._plot import plot
from ._table import Table

if TYPE_CHECKING:
    import xarray


class _Named:
    """A table as an attribute of results."""

    def __init__(self, about: str) -> None:
        self.__doc__ = about

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, results: Results | None, owner: type) -> Table:
        # On the class itself, return the descriptor for the documentation.
        return self if results is None else results.table(self._name)  # type: ignore[return-value]


class Results(Mapping[str, Table]):
    """A folder of results: a mapping from the names of tables to the tables.

    >>> import gearatlas
    >>> results = gearatlas.run("manifests/quickstart.toml", "results/quickstart", progress=False)
    >>> len(results), list(results), "poincare" in results
    (2, ['points', 'poincare'], True)
    >>> len(results["points"]), results.points is results["points"]
    (12, True)

    Tables are read on first use and compared with the checksums in the record of the run. Pickled results are the path of
    their folder, or all of their files if the folder is a temporary one.
    """

    points = _Named("One row per operating point.")
    poincare = _Named("One row per sample on a section of phase space.")
    spectra = _Named("One row per line of a spectrum.")
    orders = _Named("One row per order of a signal.")
    probes = _Named("One row per initial condition.")
    attractors = _Named("One row per attractor of a point.")
    basins = _Named("One row per cell of a slice of initial states.")
    orbits = _Named("One row per periodic orbit.")
    transitions = _Named("One row per change of motion between neighbours of a chain.")
    horizon = _Named("One row per quantity over a number of mesh cycles.")
    branches = _Named("One row per orbit of a branch.")
    bifurcations = _Named("One row per bifurcation of a branch.")
    curves = _Named("One row per point of a bifurcation curve.")
    trace = _Named("One row per instant of a traced trajectory.")
    events = _Named("One row per change of contact state of a traced trajectory.")

    def __init__(
        self, folder: str | os.PathLike[str], kept: TemporaryDirectory[str] | None = None
    ) -> None:
        self.folder = Path(folder)
        """The folder of the files."""
        self._kept = kept
        self._tables: dict[str, Table] = {}

    @property
    def tables(self) -> list[str]:
        """Names of the tables in the folder."""
        return _gearatlas.present_tables(self.folder)

    def table(self, name: str) -> Table:
        """A table by its name. Raises `AtlasError` with a remedy if the folder does not have it."""
        if name not in self._tables:
            self._tables[name] = Table(_gearatlas.read_table(self.folder, name))
        return self._tables[name]

    def __getitem__(self, name: str) -> Table:
        if name not in self.tables:
            raise KeyError(name)
        return self.table(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.tables)

    def __len__(self) -> int:
        return len(self.tables)

    # Results are equal if they are the same object: a comparison would read all files.
    __eq__ = object.__eq__
    __hash__ = object.__hash__

    @cached_property
    def records(self) -> list[dict[str, Any]]:
        """The records of the runs (`run.json`), one per shard."""
        return [json.loads(text) for text in _gearatlas.read_runs(self.folder)]

    @property
    def record(self) -> dict[str, Any]:
        """The record of the run: totals, machine, program, warnings."""
        if len(self.records) != 1:
            raise AtlasError(f"{self.folder} has {len(self.records)} records, one per shard; use `records` instead of `record`")
        return self.records[0]

    def _axes_of(self, name: str) -> Table | None:
        """The points, if the table has only their numbers."""
        return self.points if name != "points" and "points" in self else None

    def to_xarray(self, table: str = "points") -> xarray.Dataset:
        """A table as a dataset of xarray, with one dimension per axis of the grid.

        >>> import gearatlas
        >>> results = gearatlas.run("manifests/quickstart.toml", "results/quickstart", progress=False)
        >>> plane = results.to_xarray()
        >>> plane["lambda_max"].dims, plane["lambda_max"].shape, plane["speed"].attrs["units"]
        (('load', 'speed'), (3, 4), 'rad/s')
        >>> results.to_xarray("poincare")["deflection"].dims
        ('load', 'speed', 'row')

        `Table.to_xarray` describes the dimensions.
        """
        return self.table(table).to_xarray(self._axes_of(table))

    def plot(
        self,
        column: str | None = None,
        *,
        table: str | None = None,
        over: str | Sequence[str] | None = None,
        at: Mapping[str, Any] | None = None,
        units: Mapping[str, str] | None = None,
        axes: Any = None,
        **style: Any,
    ) -> Any:
        """Draws a column with Matplotlib, and returns the axes of Matplotlib.

        Over one axis of the grid with several values, the picture is a curve with standard errors, or dots for tables with
        several rows per point. Over two axes, it is a map. Branches are lines, dashed for unstable orbits.

        >>> import gearatlas
        >>> results = gearatlas.run("manifests/quickstart.toml", "results/quickstart", progress=False)
        >>> results.plot("lambda_max", units={"speed": "rpm"}).get_xlabel()
        'speed [rpm]'
        >>> results.plot("deflection", table="poincare", at={"load": 0.2}).get_title()
        'load = 0.2'
        >>> len(results.plot("force_peak", over="speed").lines)
        3

        * `column`: a column of single values, or an element such as `harmonics[1]`; by default `lambda_max`, or
          `deflection_rms`.
        * `table`: its table; by default `points`, or the branches of `follow`.
        * `over`: one or two names of axes for the picture. With one, there is a curve for each value of the others. One may
          also be another column: `over="deflection"`.
        * `at`: values of axes. The picture shows the points nearest to them.
        * `units`: units of the picture, such as `{"speed": "rpm"}`; by default SI.
        * `axes`: axes of Matplotlib to draw in; by default a new figure.
        * `style`: options of Matplotlib for the curve or the map, such as `cmap="magma"`.

        Raises `AtlasError` if the axes are ambiguous.
        """
        name = table or ("points" if "points" in self or "branches" not in self else "branches")
        return plot(self.table(name), self._axes_of(name), column, over=over, at=at, units=units, axes=axes, **style)

    def __getstate__(self) -> dict[str, Any]:
        if self._kept is None:
            return {"folder": self.folder.absolute()}
        return {"files": {path.name: path.read_bytes() for path in self.folder.iterdir() if path.is_file()}}

    def __setstate__(self, state: dict[str, Any]) -> None:
        if "folder" in state:
            Results.__init__(self, state["folder"])
            return
        kept = temporary_folder()
        Results.__init__(self, kept.name, kept)
        for name, content in state["files"].items():
            (self.folder / name).write_bytes(content)

    def __repr__(self) -> str:
        return f"<gearatlas.Results in {self.folder}: {', '.join(self.tables)}>"

    def _repr_html_(self) -> str:
        """The tables, for notebooks."""
        tables = [(name, len(self.table(name)), len(self.table(name).columns)) for name in self]
        return html_table(["table", "rows", "columns"], tables, f"results in {self.folder}")


def temporary_folder() -> TemporaryDirectory[str]:
    """A folder that lives as long as the object."""
    return TemporaryDirectory(prefix="atlas-")


def open(folder: str | os.PathLike[str]) -> Results:
    """The results in a folder that `gearatlas.run`, `gearatlas.follow` or the command line wrote."""
    results = Results(folder)
    if not results.tables:
        raise AtlasError(f"no results in `{folder}`; give a folder that `atlas run` wrote")
    return results

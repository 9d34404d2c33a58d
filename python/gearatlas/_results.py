"""Folders of results: their tables and the records of their runs."""

from __future__ import annotations

import json
import os
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from . import _gearatlas
from ._errors import AtlasError
from ._table import Table


class Results:
    """A folder of results. Tables are read on first use and compared with the checksums in the record of the run."""

    def __init__(
        self, folder: str | os.PathLike[str], kept: TemporaryDirectory[str] | None = None
    ) -> None:
        self.folder = Path(folder)
        """Where the files are."""
        self._kept = kept
        self._tables: dict[str, Table] = {}

    @property
    def tables(self) -> list[str]:
        """Names of the tables in the folder."""
        return _gearatlas.present_tables(self.folder)

    def table(self, name: str) -> Table:
        """A table by its name."""
        if name not in self._tables:
            self._tables[name] = Table(_gearatlas.read_table(self.folder, name))
        return self._tables[name]

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

    @property
    def points(self) -> Table:
        """One row per operating point."""
        return self.table("points")

    @property
    def poincare(self) -> Table:
        """One row per sample on a section of phase space."""
        return self.table("poincare")

    @property
    def spectra(self) -> Table:
        """One row per line of a spectrum."""
        return self.table("spectra")

    @property
    def orders(self) -> Table:
        """One row per order of a signal."""
        return self.table("orders")

    @property
    def probes(self) -> Table:
        """One row per initial condition."""
        return self.table("probes")

    @property
    def attractors(self) -> Table:
        """One row per attractor of a point."""
        return self.table("attractors")

    @property
    def basins(self) -> Table:
        """One row per cell of a slice of initial states."""
        return self.table("basins")

    @property
    def orbits(self) -> Table:
        """One row per periodic orbit."""
        return self.table("orbits")

    @property
    def transitions(self) -> Table:
        """One row per change of motion between neighbours of a chain."""
        return self.table("transitions")

    @property
    def horizon(self) -> Table:
        """One row per quantity over a number of mesh cycles."""
        return self.table("horizon")

    @property
    def branches(self) -> Table:
        """One row per orbit of a branch."""
        return self.table("branches")

    @property
    def bifurcations(self) -> Table:
        """One row per bifurcation of a branch."""
        return self.table("bifurcations")

    @property
    def curves(self) -> Table:
        """One row per point of a bifurcation curve."""
        return self.table("curves")

    @property
    def trace(self) -> Table:
        """One row per instant of a traced trajectory."""
        return self.table("trace")

    @property
    def events(self) -> Table:
        """One row per change of contact state of a traced trajectory."""
        return self.table("events")

    def __repr__(self) -> str:
        return f"<gearatlas.Results in {self.folder}: {', '.join(self.tables)}>"


def open(folder: str | os.PathLike[str]) -> Results:
    """The results in a folder that `gearatlas.run`, `gearatlas.follow` or the command line wrote."""
    results = Results(folder)
    if not results.tables:
        raise AtlasError(f"no results in `{folder}`; give a folder that `atlas run` wrote")
    return results

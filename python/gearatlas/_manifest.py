"""Manifests and their operating points."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _gearatlas
from ._errors import Fault, ManifestWarning
from ._html import html_table
from ._pint import plain
from ._table import Table

Changes = Mapping[str, Any]


class Axis(NamedTuple):
    """An axis of a grid."""

    name: str
    """`load`, `torque`, `speed`, or a key of the manifest."""
    unit: str
    """SI unit; `1` if dimensionless."""
    values: npt.NDArray[np.float64]
    """Its values in SI."""


class Point:
    """An operating point, on its grid or off it. It can be pickled."""

    def __init__(self, inner: _gearatlas.Point) -> None:
        self._inner = inner

    @property
    def id(self) -> int:
        """Its number on the grid, or the number of the point from which it was changed."""
        return self._inner.id

    @property
    def load(self) -> float:
        """Fraction of the rated mesh force."""
        return self._inner.load

    @property
    def speed(self) -> float:
        """Pinion speed [rad/s]."""
        return self._inner.speed

    @property
    def direction(self) -> str | None:
        """`up` or `down` if the state is carried along an axis, else None."""
        return self._inner.direction

    def __getitem__(self, key: str) -> float:
        """The value of a key on which the drive depends continuously, in SI."""
        return self._inner.value(key)

    def unit(self, key: str) -> str:
        """The SI unit of such a key."""
        return self._inner.unit(key)

    def changed(self, values: Changes | None = None, **more: float | str) -> Point:
        """The same point with other values of some keys, as numbers in SI, texts with units or quantities of pint.

        >>> import gearatlas
        >>> point = gearatlas.load("manifests/quickstart.toml").point(load=0.2)
        >>> point.changed({"mesh.half_gap": "12 um"}, speed="9000 rpm")
        <gearatlas.Point 0: load 0.2, speed 942.478 rad/s>
        """
        return Point(self._inner.changed(plain({**(values or {}), **more})))

    def __repr__(self) -> str:
        return f"<gearatlas.Point {self.id}: load {self.load:g}, speed {self.speed:g} rad/s>"


class Manifest:
    """A manifest without errors, as `atlas check` accepts it.

    It can be pickled. When it is unpickled, it reads its files again, and they must be the same.
    """

    def __init__(self, inner: _gearatlas.Manifest) -> None:
        self._inner = inner

    @classmethod
    def _warned(cls, inner: _gearatlas.Manifest) -> Manifest:
        """The manifest, after its warnings are issued at the line of the caller of this package."""
        if text := inner.warned():
            warnings.warn(text, ManifestWarning, stacklevel=_depth_of_caller())
        return cls(inner)

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], set: Changes | None = None) -> Manifest:
        """The manifest in a file."""
        return cls._warned(_gearatlas.Manifest.from_file(path, plain(set or {})))

    @classmethod
    def from_text(
        cls, text: str, set: Changes | None = None, folder: str | os.PathLike[str] = ""
    ) -> Manifest:
        """The manifest in a text. Relative paths in it start at `folder`."""
        return cls._warned(_gearatlas.Manifest.from_text(text, plain(set or {}), "text", folder))

    @classmethod
    def from_dict(
        cls, tables: Mapping[str, Any], set: Changes | None = None, folder: str | os.PathLike[str] = ""
    ) -> Manifest:
        """The manifest in a dictionary of tables. Errors quote lines of its TOML text."""
        return cls._warned(_gearatlas.Manifest.from_dict(plain(tables), plain(set or {}), folder))

    @property
    def name(self) -> str:
        """The name of the job."""
        return self._inner.name

    @property
    def hash(self) -> str:
        """Hash over everything that affects the physics."""
        return self._inner.hash

    @property
    def text(self) -> str:
        """The TOML text of the manifest."""
        return self._inner.text

    @property
    def changes(self) -> list[str]:
        """Keys with other values than in the text, as `KEY=VALUE`."""
        return self._inner.changes

    @property
    def warnings(self) -> list[Fault]:
        """Warnings, such as keys that have no effect, in the order of the text."""
        return [Fault(**warning) for warning in self._inner.warnings()]  # type: ignore[arg-type]

    @property
    def seed(self) -> int:
        """Seed of the random streams."""
        return self._inner.seed

    @property
    def keys(self) -> list[str]:
        """Keys on which the drive depends continuously. Points can change these."""
        return self._inner.keys

    @property
    def axes(self) -> list[Axis]:
        """The axes of the grid, slowest first."""
        return [Axis(*axis) for axis in self._inner.axes]

    @property
    def grid(self) -> Table:
        """The points of the grid with their numbers and the value of every axis."""
        return Table(self._inner.grid())

    @property
    def points(self) -> list[dict[str, Any]]:
        """The points of the grid as dictionaries."""
        return self.grid.to_dicts()

    def __len__(self) -> int:
        """Number of points of the grid."""
        return len(self._inner)

    def point(self, id: int = 0, values: Changes | None = None, **more: float | str) -> Point:
        """The point with a number, optionally with other values of some keys:
        `manifest.point(load=0.2, speed="10000 rpm")`."""
        return Point(self._inner.point(id, plain({**(values or {}), **more})))

    def __repr__(self) -> str:
        axes = ", ".join(f"{len(axis.values)} {axis.name}" for axis in self.axes)
        return f"<gearatlas.Manifest {self.name}: {len(self)} points ({axes})>"

    def _repr_html_(self) -> str:
        """The axes of the grid, for notebooks."""
        rows = [[axis.name, axis.unit, axis.values.size, float(axis.values.min()), float(axis.values.max())] for axis in self.axes]
        return html_table(["axis", "unit", "values", "from", "to"], rows, f"manifest {self.name}: {len(self)} points")


def _depth_of_caller() -> int:
    """Number of frames from the calling function up to the first one outside the package."""
    depth, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__package__") == __package__:
        depth, frame = depth + 1, frame.f_back
    return depth


Source = Manifest | str | os.PathLike[str] | Mapping[str, Any]


def load(source: Source, set: Changes | None = None) -> Manifest:
    """A manifest from a file, a text, a dictionary or another manifest.

    >>> import gearatlas
    >>> manifest = gearatlas.load("manifests/quickstart.toml", set={"mesh.half_gap": "20 um"})
    >>> manifest, manifest.point()["mesh.half_gap"]
    (<gearatlas.Manifest quickstart: 12 points (3 load, 4 speed)>, 2e-05)

    A text with a line break is a manifest; a text without one is the path of a file. `set` changes keys, as `--set`
    does: `set={"mesh.half_gap": "20 um", "run.cycles": 2000}`. The value None removes a key. Quantities of pint are values,
    too. Raises `ManifestError` with all errors at once. Keys that have no effect give a `ManifestWarning`.
    """
    if isinstance(source, Manifest):
        return Manifest._warned(source._inner.changed(plain(set))) if set else source
    if isinstance(source, Mapping):
        return Manifest.from_dict(source, set)
    if isinstance(source, str) and "\n" in source:
        return Manifest.from_text(source, set)
    return Manifest.from_file(Path(source), set)

"""Measured points: an axis, a value, and perhaps its standard error."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _gearatlas
from ._errors import AtlasError
from ._pint import parts

Floats = npt.NDArray[np.float64]
Points = str | os.PathLike[str] | Mapping[str, npt.ArrayLike]


@dataclass(frozen=True)
class Quantity:
    """A number, or a column of measured points, with its unit."""

    name: str
    """Its name."""
    numbers: Floats
    """Its numbers as written, (n,) or ()."""
    unit: str | None
    """Their unit; None for SI."""

    @classmethod
    def of(cls, name: str, values: Any) -> Quantity:
        """The quantity of numbers in SI, or of a quantity of pint."""
        numbers, unit = parts(values)
        return cls(name, np.array(numbers, dtype=float), unit or None)

    def in_si(self, si: str) -> Floats:
        """The numbers in the SI unit `si`, (n,) or ()."""
        return self.numbers * self.factor(si)

    def factor(self, si: str) -> float:
        """Number of SI units `si` in one unit of the quantity. Raises `AtlasError` if the units do not match."""
        if self.unit is None or self.unit == si:
            return 1.0
        factor = _gearatlas.conversion(self.unit, si)
        if factor is None:
            raise AtlasError(f"`{self.name} [{self.unit}]` does not fit {self.name}, whose unit is {si}")
        return factor


@dataclass(frozen=True)
class Measured:
    """Measured points."""

    axis: Quantity
    """Where they were measured."""
    value: Quantity
    """What was measured."""
    stderr: Quantity | None
    """Its standard errors."""


def measured_points(source: Points) -> Measured:
    """Measured points from a file, as `atlas plot --measured` reads it, or from a mapping of two or three columns in SI:
    axis, value, standard error; or of columns that are quantities of pint. Raises `ManifestError` with every fault of a file."""
    if isinstance(source, Mapping):
        columns = [Quantity.of(name, numbers) for name, numbers in source.items()]
    else:
        read = _gearatlas.read_measured(source)
        columns = [Quantity(name, numbers, unit) for name, unit, numbers in read]
    lengths = {column.numbers.shape for column in columns}
    if len(columns) not in (2, 3) or len(lengths) != 1 or len(next(iter(lengths))) != 1:
        raise AtlasError("measured points need two or three columns of one length: the axis, the value and perhaps its standard error")
    if not all(np.isfinite(column.numbers).all() for column in columns):
        raise AtlasError("measured points must be finite numbers; remove those without a value")
    if len(columns) == 3 and (columns[2].numbers < 0).any():
        raise AtlasError("a standard error of the measured points is negative")
    return Measured(columns[0], columns[1], columns[2] if len(columns) == 3 else None)

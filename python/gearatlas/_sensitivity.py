"""Derivatives of the results of a point by keys of its manifest."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

from . import _gearatlas
from ._manifest import Point
from ._table import Table


@dataclass(frozen=True)
class Sensitivity:
    """How the results of a point change with keys."""

    motion: str
    """The class of the motion, such as `periodic` or `chaotic`."""
    reason: str
    """Why the motion has this class."""
    rows: Table
    """One row per `key` and `quantity`: `value`, `derivative` in SI, `check` by differences, `stderr` of an estimate."""


def sensitivity(
    point: Point,
    by: Sequence[str] | None = None,
    *,
    members: int = 32,
    cycles: int = 2000,
    step: float = 0.02,
    tables: str | os.PathLike[str] = "tables",
) -> Sensitivity:
    """Differentiates the results of a point, as `atlas sensitivity` does.

    Derivatives of a periodic motion are exact. Those of a chaotic motion are estimates over an ensemble.

    * `by`: keys, by default all of `Manifest.keys`.
    * `members`, `cycles`: members of the ensemble, and mesh cycles of each.
    * `step`: change of each key for a chaotic motion, as a fraction of its value.

    Raises `AtlasError` if a key is unknown or the motion does not settle.
    """
    found = _gearatlas.sensitivity(
        point._inner,
        keys=None if by is None else list(by),
        members=members,
        cycles=cycles,
        step=step,
        tables=tables,
    )
    motion, reason, rows = found
    return Sensitivity(motion, reason, Table(rows))

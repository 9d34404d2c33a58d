"""Single trajectories, and the structure they move in."""

from __future__ import annotations

import os
from dataclasses import dataclass

from . import _gearatlas
from ._manifest import Point
from ._table import Table


@dataclass(frozen=True)
class Trace:
    """A recorded trajectory."""

    samples: Table
    """One row an instant: `time`, `deflection`, `velocity`, `force`, `contact`, bearing forces, and where
    asked for `displacement` and `modal_velocity`, one element a mode."""
    events: Table
    """One row a change of contact state."""
    stop: str | None
    """Why the integration ended early, where it did."""


def trace(
    point: Point,
    cycles: int = 20,
    *,
    skip: int | None = None,
    samples_per_cycle: int = 64,
    modal: bool = False,
    outputs: bool = False,
    swept: bool = False,
    tables: str | os.PathLike[str] = "tables",
) -> Trace:
    """Records a trajectory, as `atlas trace` does.

    * `cycles`: mesh cycles recorded, behind `skip` others (by default `run.transient`).
    * `samples_per_cycle`: evenly spaced, the first at mesh phase 0.
    * `modal`: records modal displacements [m sqrt(kg)] and velocities, too.
    * `outputs`: records torques, accelerations and rotations, too.
    * `swept`: starts where the sweep that the manifest asks for has come to, not from `run.initial`.
    """
    samples, events, stop = _gearatlas.trace(
        point._inner,
        cycles=cycles,
        skip=skip,
        samples_per_cycle=samples_per_cycle,
        modal=modal,
        outputs=outputs,
        swept=swept,
        tables=tables,
    )
    return Trace(Table(samples), Table(events), stop)


@dataclass(frozen=True)
class Structure:
    """What moves at an operating point."""

    modes: Table
    """One row a retained mode: `frequency`, `damping`, participations in deflection, torque, friction."""
    natural: Table
    """Natural frequencies in ascending order, contacts `open` and `closed`, and their decay."""
    mesh: Table
    """Over the mesh phase: stiffness, damping and gap of the drive flanks, imposed error."""


def structure(
    point: Point, *, samples: int = 256, tables: str | os.PathLike[str] = "tables"
) -> Structure:
    """The structure of a point, and its mesh at `samples` even phases."""
    found = _gearatlas.structure(point._inner, samples=samples, tables=tables)
    return Structure(*(Table(table) for table in found))

"""Single trajectories, and the structure of a point."""

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
    """One row per instant: `time`, `deflection`, `velocity`, `force`, `contact`, bearing forces. With `modal`, also
    `displacement` and `modal_velocity`, one element per mode."""
    events: Table
    """One row per change of contact state."""
    stop: str | None
    """Why the integration ended early; None if it did not."""


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

    * `cycles`: mesh cycles to record.
    * `skip`: mesh cycles to discard before these, by default `run.transient`.
    * `samples_per_cycle`: samples per mesh cycle, evenly spaced from mesh phase 0.
    * `modal`: also records modal displacements [m sqrt(kg)] and velocities.
    * `outputs`: also records deflections and forces of all meshes, torques, accelerations and rotations.
    * `swept`: starts from the sweep of the manifest up to this point, not from `run.initial`.
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
    """The structure and its mesh at an operating point."""

    modes: Table
    """One row per retained mode: `frequency`, `damping`, participations in deflection, torque, friction."""
    natural: Table
    """Natural frequencies in ascending order with contacts `open` and `closed`, and their decay."""
    mesh: Table
    """Stiffness, damping and gap of the drive flanks, and imposed error, over the mesh phase."""


def structure(
    point: Point, *, samples: int = 256, tables: str | os.PathLike[str] = "tables"
) -> Structure:
    """The structure of a point, and its mesh at `samples` evenly spaced phases."""
    found = _gearatlas.structure(point._inner, samples=samples, tables=tables)
    return Structure(*(Table(table) for table in found))

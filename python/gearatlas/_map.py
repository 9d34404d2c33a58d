"""The exact map of mesh cycles."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _gearatlas
from ._manifest import Changes, Point
from ._table import Table

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Image:
    """States after some mesh cycles. All values are NaN for states that could not be integrated."""

    states: Floats
    """The states, (n, 2N)."""
    jacobian: Floats | None
    """`jacobian[s, i, j]`: derivative of component i at the end with respect to component j at the start, (n, 2N, 2N).
    It includes saltation at events."""
    tangents: Floats | None
    """The given tangents, mapped to the end, (n, k, 2N)."""
    by: dict[str, Floats]
    """Derivatives with respect to keys of the manifest, in SI and at fixed mesh phase, (n, 2N) each."""
    events: Table | None
    """Events, one per row, with the row of their `state`."""
    stops: dict[int, str]
    """Rows of states that could not be integrated, and why."""


class CycleMap:
    """The map of an operating point over whole mesh cycles: `map(states)`.

    States are rows of 2N numbers, in the coordinates that the kernel integrates. With modal damping these are modal
    displacements [m sqrt(kg)], then modal velocities [m sqrt(kg)/s]. Rigid motions are rotated so that only one of them
    deflects the mesh; `from_modal` and `to_modal` convert. The bits are those of a run, for any number of threads and
    states.

    The state determines which contacts are closed. If the excitation does not repeat every mesh cycle, the map depends
    on the cycle; it repeats after `base_period` cycles.
    """

    def __init__(
        self,
        point: Point,
        *,
        threads: int | None = None,
        tables: str | os.PathLike[str] = "tables",
    ) -> None:
        self._inner = _gearatlas.CycleMap(point._inner, threads, tables)
        self._point = point
        self._asked: dict[str, Any] = {"threads": threads, "tables": tables}

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(CycleMap, self._point, **self._asked), ()

    @property
    def point(self) -> Point:
        """The operating point."""
        return self._point

    def at(self, values: Changes | None = None, **more: float | str) -> CycleMap:
        """The map with other values of some keys of the manifest: `map.at(load=0.1)`."""
        return CycleMap(self.point.changed(values, **more), **self._asked)

    @property
    def threads(self) -> int:
        """Threads that map states."""
        return self._inner.threads

    @property
    def modes(self) -> int:
        """Modes N."""
        return self._inner.modes

    @property
    def dimension(self) -> int:
        """Length 2N of a state."""
        return self._inner.dimension

    @property
    def period(self) -> float:
        """Mesh period [s]."""
        return self._inner.period

    @property
    def half_gap(self) -> float:
        """Half of the backlash [m]."""
        return self._inner.half_gap

    @property
    def base_period(self) -> int | None:
        """Mesh cycles after which the map repeats; None if it never does."""
        return self._inner.base_period

    @property
    def kernel(self) -> str:
        """The kernel, `run.kernel` of the manifest. The map keeps the tables of `volterra`. It builds other tables in each call."""
        return self._inner.kernel

    @property
    def weighted_components(self) -> npt.NDArray[np.intp]:
        """Components of a state that affect the motion: all except rotations of the whole drive."""
        return self._inner.weighted_components.astype(np.intp)

    @property
    def weights(self) -> Floats:
        """Weight of each component in the energy norm, in half gaps: `norm(weights * (x - y))`."""
        return self._inner.weights

    def start(self) -> Floats:
        """The state from `run.initial`, (2N,)."""
        return self._inner.start()

    def from_modal(self, displacement: npt.ArrayLike, velocity: npt.ArrayLike) -> Floats:
        """The state from modal displacements and velocities of the structure, as in `trace` and manifests, (2N,)."""
        return self._inner.state_of_modal(_floats(displacement), _floats(velocity))

    def to_modal(self, states: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Modal displacements and velocities of states, (n, N) each."""
        displacement, velocity = self._inner.to_modal(self._rows(states))
        return displacement, velocity

    def deflection(self, states: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Mesh deflection [m] and its rate [m/s] of states at the start of the first mesh cycle of a base period, (n,)
        each."""
        deflection, rate = self._inner.deflection(self._rows(states))
        return deflection, rate

    def __call__(self, states: npt.ArrayLike, cycles: int = 1, *, first_cycle: int = 0) -> Floats:
        """The states after some mesh cycles, in the given shape: (n, 2N) or (2N,)."""
        rows = self._rows(states)
        ends = self._inner.image(rows, cycles, first_cycle, False, None, [], False)[0]
        return ends.reshape(np.shape(states))

    def image(
        self,
        states: npt.ArrayLike,
        cycles: int = 1,
        *,
        first_cycle: int = 0,
        jacobian: bool = False,
        tangents: npt.ArrayLike | None = None,
        by: Iterable[str] = (),
        events: bool = False,
    ) -> Image:
        """Maps states, (n, 2N) or (2N,), over some mesh cycles. The first of these has the number `first_cycle`.

        * `jacobian`: also returns the derivatives with respect to the states.
        * `tangents`: vectors (n, k, 2N) to which the derivatives are applied, which is faster than the full Jacobian.
        * `by`: keys of the manifest to differentiate with respect to: `load`, `speed`, `mesh.half_gap`, ...
        * `events`: also returns the events.
        """
        if jacobian and tangents is not None:
            raise ValueError("give tangents= or jacobian=True, not both")
        keys = list(by)
        vectors = None if tangents is None else _floats(tangents)
        ends, columns, along, met, stops = self._inner.image(
            self._rows(states), cycles, first_cycle, jacobian, vectors, keys, events
        )
        return Image(
            states=ends,
            jacobian=columns if jacobian else None,
            tangents=None if jacobian else columns,
            by={} if along is None else {key: along[:, i] for i, key in enumerate(keys)},
            events=None if met is None else Table(met),
            stops=dict(stops),
        )

    def _rows(self, states: npt.ArrayLike) -> Floats:
        rows = _floats(states)
        return rows[np.newaxis, :] if rows.ndim == 1 else rows

    def __repr__(self) -> str:
        return f"<gearatlas.CycleMap of {self.point!r}: {self.modes} modes, {self.kernel}>"


def _floats(values: npt.ArrayLike) -> Floats:
    return np.ascontiguousarray(values, dtype=np.float64)

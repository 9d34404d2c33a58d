"""The exact map of mesh cycles."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _gearatlas
from ._manifest import Changes, Point
from ._table import Table

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Image:
    """Where states come to after some mesh cycles. Of states that could not be integrated everything is
    NaN."""

    states: Floats
    """The states, (n, 2N)."""
    jacobian: Floats | None
    """`jacobian[s, i, j]`: derivative of component i at the end by component j at the start, (n, 2N, 2N);
    saltation at events included."""
    tangents: Floats | None
    """The tangents that were given, at the end, (n, k, 2N)."""
    by: dict[str, Floats]
    """Derivatives by keys of the manifest in SI, at fixed mesh phase, (n, 2N) each."""
    events: Table | None
    """Events, one a row, with the row of the `state` that met it."""
    stops: dict[int, str]
    """Rows of states that could not be integrated, and why."""


class CycleMap:
    """The map of an operating point over whole mesh cycles: `map(states)`.

    States are rows of 2N numbers, in the coordinates that the kernel integrates: with modal damping
    modal displacements [m sqrt(kg)], then modal velocities [m sqrt(kg)/s], rigid motions turned so that
    the mesh feels one of them (`from_modal` and `to_modal` know how). The bits are those of a run,
    for any number of threads and states.

    Which contacts are closed follows from a state. The map of a drive whose excitation does not repeat
    with the mesh depends on the cycle: `base_period` says after how many it is the same again.
    """

    def __init__(
        self,
        point: Point,
        *,
        threads: int | None = None,
        tables: str | os.PathLike[str] = "tables",
    ) -> None:
        self._inner = _gearatlas.CycleMap(point._inner, threads, tables)
        self._asked = (threads, tables)

    @property
    def point(self) -> Point:
        """The operating point."""
        return Point(self._inner.point)

    def at(self, values: Changes | None = None, **more: float | str) -> CycleMap:
        """The map where some keys of the manifest have other values: `map.at(load=0.1)`."""
        threads, tables = self._asked
        return CycleMap(self.point.changed(values, **more), threads=threads, tables=tables)

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
        """Mesh cycles after which the map is the same again; none where it never is."""
        return self._inner.base_period

    @property
    def kernel(self) -> str:
        """The kernel, `run.kernel` of the manifest. `volterra` is kept between calls; others are built
        at each."""
        return self._inner.kernel

    @property
    def felt(self) -> npt.NDArray[np.intp]:
        """Components of a state that something feels: all but those of rotations of the whole drive."""
        return self._inner.felt.astype(np.intp)

    @property
    def weights(self) -> Floats:
        """Weight of each component in the energy norm, in half gaps: `norm(weights * (x - y))`."""
        return self._inner.weights

    def start(self) -> Floats:
        """The state that `run.initial` gives, (2N,)."""
        return self._inner.start()

    def from_modal(self, displacement: npt.ArrayLike, velocity: npt.ArrayLike) -> Floats:
        """The state of modal displacements and velocities of the structure, as `trace` and manifests
        have them, (2N,)."""
        return self._inner.state_of_modal(_floats(displacement), _floats(velocity))

    def to_modal(self, states: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Modal displacements and velocities of states, (n, N) each."""
        displacement, velocity = self._inner.to_modal(self._rows(states))
        return displacement, velocity

    def deflection(self, states: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Mesh deflection [m] and its rate [m/s] of states at the start of the first mesh cycle of a base
        period, (n,) each."""
        deflection, rate = self._inner.deflection(self._rows(states))
        return deflection, rate

    def __call__(self, states: npt.ArrayLike, cycles: int = 1, *, first_cycle: int = 0) -> Floats:
        """The states after some mesh cycles, in the shape given: (n, 2N) or (2N,)."""
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
        """Maps states, (n, 2N) or one of (2N,), over some mesh cycles, the first of which has the number
        `first_cycle`.

        * `jacobian`: gives the derivatives by the states, too.
        * `tangents`: vectors (n, k, 2N) that the derivatives are applied to, which takes less than all
          of them.
        * `by`: keys of the manifest to differentiate by: `load`, `speed`, `mesh.half_gap`, ...
        * `events`: gives the events, too.
        """
        if jacobian and tangents is not None:
            raise ValueError("give tangents, or ask for the jacobian: not both at once")
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

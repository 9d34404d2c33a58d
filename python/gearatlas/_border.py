"""States on the border of two basins, and the saddle that they lead to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ._errors import AtlasError
from ._map import CycleMap, Floats

_SECTIONS = 15
"""Number of states between two ends that are mapped together: four bisections at once."""
_RECORD = 240
"""Number of states that describe an attractor."""
_APART = 1e-6
"""Distance at which two motions differ, and at which the border's motion repeats, as a part of its size."""
_NEWTON_STEPS = 12
_CONVERGED = 1e-13


@dataclass(frozen=True)
class Border:
    """A point on the border of two basins, and the motion from it."""

    state: Floats
    """The state on the line between the starts, (2N,)."""
    width: float
    """Distance between the states on either side of the border, in half gaps of the energy norm."""
    track: Floats
    """The motion of this state along the border, base period by base period, (m, 2N)."""
    saddle: Floats | None
    """The orbit that the motion approaches, (2N,); None if the motion does not repeat within the track."""
    period: int | None
    """Period of the orbit, in mesh cycles."""
    multipliers: npt.NDArray[np.complex128] | None
    """Floquet multipliers of the orbit, the largest modulus first. A saddle has one outside the unit circle."""


def border(
    map: CycleMap,
    one: npt.ArrayLike,
    other: npt.ArrayLike,
    *,
    cycles: int = 1000,
    tolerance: float = 1e-12,
    track: int = 400,
    longest_period: int = 12,
) -> Border:
    """The border of the basins of two motions on the line between two starts, (2N,) each, and the saddle on it.

    >>> import gearatlas
    >>> manifest = gearatlas.load("manifests/oscillators/one-sided-stop.toml")
    >>> map = gearatlas.CycleMap(manifest.point(0, {"contact.stop.gap": 0.195, "contact.stop.stiffness": 30.0}))
    >>> found = gearatlas.border(map, [0.0, 0.0], [0.0, -0.9])
    >>> found.period, int((abs(found.multipliers) > 1).sum())
    (2, 1)

    Bisection finds two neighbours on either side. Both are mapped on together, and bisection between their images keeps
    them close. They follow the border to its own attractor, which repels only across the border. If it repeats, Newton's
    method closes it. If the line meets several borders, one of them is found.

    * `cycles`: base periods until a start has settled. A start near the border needs more than others.
    * `tolerance`: width at which bisection ends, as a part of the size of the starts.
    * `track`: base periods along the border.
    * `longest_period`: of the saddle, in base periods.

    Raises `AtlasError` if both starts lead to the same motion.

    Source: Skufca, Yorke & Eckhardt, Phys. Rev. Lett. 96, 2006, 174101.
    """
    basins = _Basins(map, np.array(one, dtype=np.float64), np.array(other, dtype=np.float64), cycles)
    ends = basins.divided(basins.ends, tolerance)
    points, width = [ends.mean(axis=0)], float(basins.size(ends[1] - ends[0]))
    apart = max(_APART * basins.scale, 100.0 * width)
    for _ in range(track):
        ends = map(ends, basins.step)
        if not basins.size(ends[1] - ends[0]) < 1e-2 * apart:
            ends = basins.divided(ends, tolerance)
        points.append(ends.mean(axis=0))
        period = basins.repeated(points, longest_period, apart)
        if period is not None:
            closed = basins.closed(points[-1], period)
            if closed is not None:
                return Border(points[0], width, np.array(points), closed[0], period * basins.step, closed[1])
    return Border(points[0], width, np.array(points), None, None, None)


class _Basins:
    """Two starts, and a test for which of their two motions another start leads to."""

    def __init__(self, map: CycleMap, one: Floats, other: Floats, cycles: int) -> None:
        if map.base_period is None:
            raise AtlasError("the map never repeats: an excitation has an order without `cycles = [p, q]`")
        self.map, self.step, self.cycles = map, map.base_period, cycles
        self.weighted, self.weights = map.weighted_components, map.weights[map.weighted_components]
        self.ends = np.stack([one, other])
        states, clouds = map(self.ends, cycles * self.step), []
        for _ in range(_RECORD):
            states = map(states, self.step)
            clouds.append(states)
        self.clouds = np.swapaxes(np.array(clouds), 0, 1)
        self.scale = float(max(self.size(self.ends).max(), self.size(self.clouds).max()))
        nearest = self.size(self.clouds[0] - self.clouds[1, -1]).min()
        if not nearest > _APART * self.scale:
            raise AtlasError("both starts lead to the same motion; choose starts in different basins")

    def size(self, states: Floats) -> Floats:
        sizes: Floats = np.linalg.norm(self.weights * states[..., self.weighted], axis=-1)
        return sizes

    def divided(self, ends: Floats, tolerance: float) -> Floats:
        """Two neighbours on the line between states (2, 2N). The first leads to the first motion."""
        while self.size(ends[1] - ends[0]) > tolerance * self.scale:
            shares = np.arange(1, _SECTIONS + 1)[:, np.newaxis] / (_SECTIONS + 1)
            between = ends[0] + shares * (ends[1] - ends[0])
            states = np.concatenate([ends[:1], between, ends[1:]])
            led = np.concatenate([[True], self._first(between), [False]])
            after = int(np.flatnonzero(~led)[0])
            narrowed = states[after - 1 : after + 1]
            if np.array_equal(narrowed, ends):
                break
            ends = narrowed
        return ends

    def _first(self, states: Floats) -> npt.NDArray[np.bool_]:
        """Whether states lead to the first motion rather than to the second."""
        settled = self.map(states, self.cycles * self.step)
        gaps = [self.size(settled[:, np.newaxis] - cloud).min(axis=1) for cloud in self.clouds]
        return np.asarray(gaps[0] < gaps[1])

    def repeated(self, points: list[Floats], longest: int, apart: float) -> int | None:
        """The period after which the last points repeat, in base periods."""
        for period in range(1, min(longest, len(points) // 2) + 1):
            if all(self.size(points[-1 - i] - points[-1 - i - period]) < apart for i in range(period)):
                return period
        return None

    def closed(self, state: Floats, period: int) -> tuple[Floats, npt.NDArray[np.complex128]] | None:
        """The orbit near a state by Newton's method, with its multipliers; None if none is found nearby."""
        state, start = state.copy(), state
        for _ in range(_NEWTON_STEPS):
            image = self.map.image(state, period * self.step, jacobian=True)
            assert image.jacobian is not None
            slope = image.jacobian[0][np.ix_(self.weighted, self.weighted)]
            off = (image.states[0] - state)[self.weighted]
            change = np.linalg.solve(slope - np.eye(len(off)), off)
            state[self.weighted] -= change
            if np.linalg.norm(self.weights * change) < _CONVERGED * self.scale:
                break
        if not self.size(state - start) < 1e-3 * self.scale:
            return None
        multipliers = np.linalg.eigvals(slope).astype(np.complex128)
        return state, multipliers[np.argsort(-np.abs(multipliers))]

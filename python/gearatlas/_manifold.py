"""Stable and unstable manifolds of saddle orbits, as curves and surfaces."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ._map import CycleMap, Floats

_NEWTON_STEPS = 12
_CONVERGED = 1e-11
_LEAST_SHARE = 1e-7
"""Shortest piece of a curve whose image is still divided, as a part of `step`."""


def manifold(
    map: CycleMap,
    state: npt.ArrayLike,
    period: int = 1,
    *,
    stable: bool = False,
    length: float = 100.0,
    step: float = 0.1,
    offset: float = 1e-4,
) -> tuple[Floats, Floats]:
    """The two branches of the unstable manifold of a saddle orbit, or of its stable manifold, (n, 2N) states each.

    Rows run from the orbit outwards. The map over one period, or over two if the multiplier is negative, takes the
    unstable manifold into itself. A short piece along the eigenvector is mapped again and again. New points are inserted
    where images are farther apart than `step`. The stable manifold is found with the inverse map, by Newton's method.

    * `state`: a point (2N,) of the orbit at the start of a cycle, such as a row of `branches.parquet`.
    * `period`: of the orbit, in mesh cycles.
    * `length`: of each branch, in half gaps of the energy norm (`map.weights`). A branch ends earlier if its points
      cannot be mapped.
    * `step`: largest distance between neighbours, in the same unit.
    * `offset`: distance from the orbit at which the curve starts. There it is a straight line.

    Raises ValueError unless the orbit has exactly one multiplier outside the unit circle (inside it for `stable`).
    Otherwise its manifold is not a curve.

    Source: Hobson, J. Comput. Phys. 104, 1993, 14-22. `examples/manifolds.py` draws both manifolds.
    """
    grown = _Grown(map, np.array(state, dtype=np.float64), period, stable)
    return tuple(grown.branch(sign * offset, length, step) for sign in (1.0, -1.0))  # type: ignore[return-value]


def manifold_surface(
    map: CycleMap,
    state: npt.ArrayLike,
    period: int = 1,
    *,
    stable: bool = False,
    length: float = 10.0,
    step: float = 0.5,
    offset: float = 1e-3,
    rings: int = 8,
    rays: int = 2000,
) -> Floats:
    """The unstable manifold of a saddle orbit with two unstable directions, or its stable one, as a grid (m, n, 2N) of states.

    The first axis counts closed rings around the orbit, outwards. The second counts rays, which are joined at their ends: the
    last is a neighbour of the first. The first rings are linear images of a circle in the plane of both eigenvectors. The
    outward map takes a ring to the ring `rings` places later, on the same rays. A ray is inserted where neighbours in a new
    ring are farther apart than `step`.

    * `state`, `period`: as in `manifold`. A negative multiplier doubles the period.
    * `length`: mean distance from the orbit at which the surface ends, in half gaps of the energy norm (`map.weights`). It
      ends earlier if points cannot be mapped, or if it would need more rays than `rays`.
    * `step`: largest distance between neighbours in a ring, in the same unit.
    * `offset`: radius of the first ring, in the same unit. The error of the surface there is of the order `offset`².

    Raises ValueError unless exactly two multipliers are outside the unit circle (inside it for `stable`).
    """
    surface = _Surface(map, np.array(state, dtype=np.float64), period, stable, offset, rings)
    return surface.grown(length, step, rays)


class _Outwards:
    """The map that moves points outwards along a manifold of some dimension."""

    def __init__(self, map: CycleMap, orbit: Floats, period: int, stable: bool, directions: int) -> None:
        self.map, self.orbit, self.stable = map, orbit, stable
        self.weighted, self.weights = map.weighted_components, map.weights[map.weighted_components]
        self.cycles = period
        values, vectors = np.linalg.eig(self._slope(orbit))
        own = np.abs(values) < 1.0 if stable else np.abs(values) > 1.0
        if own.sum() != directions:
            where = "inside" if stable else "outside"
            kind = {1: "a curve only if there is one", 2: "a surface only if there are two"}[directions]
            raise ValueError(f"the orbit has {own.sum()} multipliers {where} the unit circle; its manifold is {kind}")
        self.vectors = vectors[:, own] / np.linalg.norm(self.weights[:, np.newaxis] * vectors[:, own], axis=0)
        self.growth = values[own] ** (-1 if stable else 1)
        if ((self.growth.real < 0.0) & (self.growth.imag == 0.0)).any():
            self.cycles, self.growth = 2 * period, self.growth**2

    def _mapped(self, points: Floats, guesses: Floats) -> Floats:
        """Images of points under the outward map; NaN if not found."""
        if not self.stable:
            return self.map(points, self.cycles)
        found = guesses.copy()
        for _ in range(_NEWTON_STEPS):
            images, slope = self._images(found)
            off = (images - points)[:, self.weighted]
            usable = np.isfinite(off).all(axis=1) & np.isfinite(slope).all(axis=(1, 2))
            change = np.full_like(off, np.nan)
            change[usable] = np.linalg.solve(slope[usable], off[usable][:, :, np.newaxis])[:, :, 0]
            found[:, self.weighted] -= change
            size = np.linalg.norm(self.weights * change, axis=1)
            known = ~(size > _CONVERGED * (1.0 + np.linalg.norm(self.weights * found[:, self.weighted], axis=1)))
            if known.all():
                return found
        found[~known] = np.nan
        return found

    def _slope(self, state: Floats) -> Floats:
        """Derivative of the map at a state."""
        slope: Floats = self._images(state)[1][0]
        return slope

    def _images(self, states: Floats) -> tuple[Floats, Floats]:
        """Images of states under the map, and its derivatives there."""
        image = self.map.image(states, self.cycles, jacobian=True)
        assert image.jacobian is not None
        return image.states, image.jacobian[:, self.weighted][:, :, self.weighted]

    def _gaps(self, points: Floats) -> Floats:
        gaps: Floats = np.linalg.norm(self.weights * np.diff(points[:, self.weighted], axis=0), axis=1)
        return gaps


class _Grown(_Outwards):
    """A manifold that is a curve."""

    def __init__(self, map: CycleMap, orbit: Floats, period: int, stable: bool) -> None:
        super().__init__(map, orbit, period, stable, 1)
        self.direction, self.factor = self.vectors[:, 0].real, self.growth[0].real

    def branch(self, offset: float, length: float, step: float) -> Floats:
        """A branch, from the orbit outwards."""
        start = np.tile(self.orbit, (2, 1))
        start[0, self.weighted] += offset * self.direction
        start[1, self.weighted] += offset * self.factor * self.direction
        piece, pieces, travelled = start, [start], 0.0
        while travelled < length:
            images = self._drawn_back(piece, step) if self.stable else self._drawn_on(piece, step)
            pieces.append(images[1:])
            walked = self._gaps(images).sum()
            # The branch winds onto an attractor, or grows no further.
            if len(images) < len(piece) or walked < _LEAST_SHARE * step:
                break
            piece, travelled = self._thinned(images, 0.5 * step), travelled + walked
        points = self._thinned(np.concatenate([self.orbit[np.newaxis], *pieces]), 0.5 * step)
        walked = np.concatenate([[0.0], np.cumsum(self._gaps(points))])
        return points[: int(np.searchsorted(walked, length, side="right"))]

    def _drawn_on(self, piece: Floats, step: float) -> Floats:
        """The image of a piece of the curve, with points inserted where it is coarse; it ends at a point without an image."""
        images = self._mapped(piece, piece)
        while True:
            coarse = self._gaps(images) > step
            coarse &= self._gaps(piece) > _LEAST_SHARE * step
            after = np.flatnonzero(coarse)
            if not len(after):
                break
            between = 0.5 * (piece[after] + piece[after + 1])
            piece = np.insert(piece, after + 1, between, axis=0)
            images = np.insert(images, after + 1, self._mapped(between, between), axis=0)
        bad = np.flatnonzero(~np.isfinite(images).all(axis=1))
        return images[: bad[0]] if len(bad) else images

    def _drawn_back(self, piece: Floats, step: float) -> Floats:
        """The preimage of a piece of the curve from its second point on; the preimage of the first is the last point."""
        known, images = piece[0], [piece[-1]]
        ahead = list(piece[:0:-1])
        while ahead:
            slope = self._slope(images[-1])
            guess = images[-1].copy()
            guess[self.weighted] += np.linalg.solve(slope, (ahead[-1] - known)[self.weighted])
            found = self._mapped(ahead[-1][np.newaxis], guess[np.newaxis])[0]
            if not self._gaps(np.stack([images[-1], found]))[0] <= step:
                if self._gaps(np.stack([known, ahead[-1]]))[0] > _LEAST_SHARE * step:
                    ahead.append(0.5 * (known + ahead[-1]))
                    continue
                if np.isnan(found).any():
                    break
            known = ahead.pop()
            images.append(found)
        return np.array(images)

    def _thinned(self, points: Floats, least: float) -> Floats:
        """The points, without those closer than `least` to the previous one; the last is kept."""
        scaled = self.weights * points[:, self.weighted]
        kept = [0]
        for i in range(1, len(points)):
            if np.linalg.norm(scaled[i] - scaled[kept[-1]]) >= least or i == len(points) - 1:
                kept.append(i)
        return points[kept]


class _Surface(_Outwards):
    """A manifold that is a surface."""

    def __init__(self, map: CycleMap, orbit: Floats, period: int, stable: bool, offset: float, rings: int) -> None:
        super().__init__(map, orbit, period, stable, 2)
        self.offset, self.rings = offset, rings

    def grown(self, length: float, step: float, most: int) -> Floats:
        angles = np.linspace(0.0, 1.0, 64, endpoint=False)
        states = self._rays(angles, self.rings)
        while True:
            grown = np.concatenate([states, self._next(states, angles)[np.newaxis]])
            while len(after := self._coarse(grown[-1], angles, step)):
                between = angles[after] + 0.5 * np.diff(np.append(angles, 1.0))[after]
                angles = np.insert(angles, after + 1, between)
                if len(angles) > most:
                    return states
                grown = np.insert(grown, after + 1, self._rays(between, len(grown)), axis=1)
            if not np.isfinite(grown[-1]).all():
                return states
            states = grown
            if np.linalg.norm(self.weights * (states[-1] - self.orbit)[:, self.weighted], axis=1).mean() >= length:
                return states

    def _first(self, ring: int, angles: Floats) -> Floats:
        """A ring near the orbit, where the map is linear."""
        turn = 2.0 * np.pi * angles
        factors = self.growth.astype(complex) ** (ring / self.rings)
        both = np.stack([np.cos(turn), np.sin(turn)])
        if self.growth[0].imag != 0.0:
            along = (self.vectors[:, :1] * factors[0] * (both[0] + 1j * both[1])).real
        else:
            along = self.vectors.real @ (factors.real[:, np.newaxis] * both)
        states = np.tile(self.orbit, (len(angles), 1))
        states[:, self.weighted] += self.offset * along.T
        return states

    def _next(self, states: Floats, angles: Floats) -> Floats:
        """The ring after the given ones."""
        points = states[-self.rings]
        if len(states) == self.rings or not self.stable:
            return self._mapped(points, self._first(self.rings, angles))
        # The inverse map is nearly linear between neighbouring rings.
        guesses = states[-1].copy()
        _, slopes = self._images(guesses)
        usable = np.isfinite(slopes).all(axis=(1, 2))
        apart = (points - states[-self.rings - 1])[usable][:, self.weighted, np.newaxis]
        guesses[np.ix_(usable, self.weighted)] += np.linalg.solve(slopes[usable], apart)[:, :, 0]
        return self._mapped(points, guesses)

    def _rays(self, angles: Floats, count: int) -> Floats:
        """The first rings on some rays."""
        states = np.stack([self._first(ring, angles) for ring in range(self.rings)])
        while len(states) < count:
            states = np.concatenate([states, self._next(states, angles)[np.newaxis]])
        return states

    def _coarse(self, ring: Floats, angles: Floats, step: float) -> npt.NDArray[np.intp]:
        """Rays after which a ring needs another one."""
        gaps = self._gaps(np.concatenate([ring, ring[:1]]))
        return np.flatnonzero((gaps > step) & (np.diff(np.append(angles, 1.0)) > _LEAST_SHARE))

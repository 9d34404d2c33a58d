"""Stable and unstable manifolds of saddle orbits, as curves."""

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


class _Grown:
    """The map that moves points outwards along a manifold."""

    def __init__(self, map: CycleMap, orbit: Floats, period: int, stable: bool) -> None:
        self.map, self.orbit, self.stable = map, orbit, stable
        self.felt, self.weights = map.felt, map.weights[map.felt]
        self.cycles = period
        monodromy = self._slope(orbit)
        values, vectors = np.linalg.eig(monodromy)
        own = np.abs(values) < 1.0 if stable else np.abs(values) > 1.0
        if own.sum() != 1:
            where = "inside" if stable else "outside"
            raise ValueError(
                f"the orbit has {own.sum()} multipliers {where} the unit circle; its manifold is a curve only if there is one"
            )
        vector = vectors[:, own][:, 0].real
        self.direction = vector / np.linalg.norm(self.weights * vector)
        self.growth = abs(values[own][0].real) ** (-1 if stable else 1)
        if values[own][0].real < 0.0:
            self.cycles, self.growth = 2 * period, self.growth**2

    def branch(self, offset: float, length: float, step: float) -> Floats:
        """A branch, from the orbit outwards."""
        start = np.tile(self.orbit, (2, 1))
        start[0, self.felt] += offset * self.direction
        start[1, self.felt] += offset * self.growth * self.direction
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
            guess[self.felt] += np.linalg.solve(slope, (ahead[-1] - known)[self.felt])
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
        scaled = self.weights * points[:, self.felt]
        kept = [0]
        for i in range(1, len(points)):
            if np.linalg.norm(scaled[i] - scaled[kept[-1]]) >= least or i == len(points) - 1:
                kept.append(i)
        return points[kept]

    def _mapped(self, points: Floats, guesses: Floats) -> Floats:
        """Images of points under the outward map; NaN if not found."""
        if not self.stable:
            return self.map(points, self.cycles)
        found = guesses.copy()
        for _ in range(_NEWTON_STEPS):
            image = self.map.image(found, self.cycles, jacobian=True)
            assert image.jacobian is not None
            off = (image.states - points)[:, self.felt]
            slope = image.jacobian[:, self.felt][:, :, self.felt]
            usable = np.isfinite(off).all(axis=1) & np.isfinite(slope).all(axis=(1, 2))
            change = np.full_like(off, np.nan)
            change[usable] = np.linalg.solve(slope[usable], off[usable][:, :, np.newaxis])[:, :, 0]
            found[:, self.felt] -= change
            size = np.linalg.norm(self.weights * change, axis=1)
            known = ~(size > _CONVERGED * (1.0 + np.linalg.norm(self.weights * found[:, self.felt], axis=1)))
            if known.all():
                return found
        found[~known] = np.nan
        return found

    def _slope(self, state: Floats) -> Floats:
        """Derivative of the map at a state."""
        image = self.map.image(state, self.cycles, jacobian=True)
        assert image.jacobian is not None
        slope: Floats = image.jacobian[0][np.ix_(self.felt, self.felt)]
        return slope

    def _gaps(self, points: Floats) -> Floats:
        gaps: Floats = np.linalg.norm(self.weights * np.diff(points[:, self.felt], axis=0), axis=1)
        return gaps

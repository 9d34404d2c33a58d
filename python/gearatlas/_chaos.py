"""Chaotic saddles: the sets behind transient chaos, and how fast motions leave them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ._errors import AtlasError
from ._map import CycleMap, Floats

Inside = Callable[[Floats], npt.NDArray[np.bool_]]
"""Whether states (n, d) are still in the region of the transient, (n,)."""
Mapping = CycleMap | Callable[[Floats], Floats]

_CANDIDATES = 24
"""Number of displaced states that are tried together for each walker."""
_TRIES = 400
_GROUPS = 8
"""Number of groups of walkers. The spread between groups gives standard errors."""


@dataclass(frozen=True)
class Escape:
    """How fast states leave a region, per application of the map."""

    rate: float
    """Escape rate κ: the number of remaining states falls as exp(−κ n)."""
    stderr: float
    """Its standard error."""
    survivors: npt.NDArray[np.intp]
    """Number of starts that remain after 0, 1, 2, ... applications."""


def escape(map: Mapping, inside: Inside, starts: npt.ArrayLike, *, after: int, most: int) -> Escape:
    """The escape rate from the number of starts (n, d) that remain in a region.

    >>> import numpy, gearatlas
    >>> tent = lambda states: 3.0 * numpy.minimum(states, 1.0 - states)
    >>> inside = lambda states: (states[:, 0] >= 0.0) & (states[:, 0] <= 1.0)
    >>> starts = numpy.random.default_rng(1).random((100000, 1))
    >>> found = gearatlas.escape(tent, inside, starts, after=2, most=20)
    >>> bool(abs(found.rate - numpy.log(1.5)) < 3 * found.stderr), bool(found.stderr < 0.01)
    (True, True)

    * `after`: applications before exits count. The first exits depend on the starts.
    * `most`: applications after which remaining states are no longer observed.

    The rate is the maximum-likelihood estimate for a constant chance to leave, −log(1 − exits/chances).

    Raises `AtlasError` if no state leaves after `after`.
    """
    lives = _lives(map, inside, np.array(starts, dtype=np.float64), most)
    survivors = np.array([(lives >= n).sum() for n in range(most + 1)])
    exits, chances = survivors[after] - survivors[-1], survivors[after:-1].sum()
    if exits == 0:
        raise AtlasError("no start leaves the region after `after`; take more starts or a larger `most`")
    chance = exits / chances
    return Escape(float(-np.log1p(-chance)), float(np.sqrt(chance / (1.0 - chance) / chances)), survivors)


@dataclass(frozen=True)
class ChaoticSaddle:
    """Long trajectories near a chaotic saddle."""

    states: Floats
    """States of all walkers, (walkers, length, d)."""
    largest: float
    """Largest displacement, as a part of the size of the starts in each component."""

    def exponents(self, slope: Callable[[Floats], Floats]) -> tuple[Floats, Floats]:
        """Lyapunov exponents per application of the map, the largest first, and standard errors, (d,) each.

        `slope(states)` returns the derivatives of the map, (n, d, d).
        """
        walkers, length, width = self.states.shape
        slopes = slope(self.states[:, :-1].reshape(-1, width)).reshape(walkers, length - 1, width, width)
        frames, sums, begun = np.tile(np.eye(width), (walkers, 1, 1)), np.zeros((walkers, width)), (length - 1) // 10
        for i in range(length - 1):
            frames, triangles = np.linalg.qr(slopes[:, i] @ frames)
            if i >= begun:
                sums += np.log(np.abs(np.diagonal(triangles, axis1=1, axis2=2)))
        means = sums / (length - 1 - begun)
        return means.mean(axis=0), means.std(axis=0, ddof=1) / np.sqrt(walkers)

    def escape_rate(self, slope: Callable[[Floats], Floats]) -> tuple[float, float]:
        """Escape rate κ = Σλ⁺ − h of a saddle in one or two dimensions, and its standard error.

        The entropy is h = D/Σ(1/|λ|) with the information dimension D.

        Source: Kantz & Grassberger, Physica D 17, 1985, 75-86; Hsu, Ott & Grebogi, Phys. Lett. A 127, 1988, 199-204.
        """
        exponents, stderr = self.exponents(slope)
        dimension, unsure = self.dimension()
        if len(exponents) > 2:
            raise ValueError(f"the entropy follows from the dimension in one or two dimensions only, not in {len(exponents)}")
        inverse = (1.0 / np.abs(exponents)).sum()
        rate = exponents[exponents > 0.0].sum() - dimension / inverse
        # Derivatives of the rate with respect to the exponents and to the dimension.
        by = (exponents > 0.0) - dimension / inverse**2 * np.sign(exponents) / exponents**2
        return float(rate), float(np.hypot(np.linalg.norm(by * stderr), unsure / inverse))

    def dimension(self) -> tuple[float, float]:
        """Information dimension of the saddle from distances of nearest neighbours, and its standard error.

        The mean logarithm of the distance falls as log(n)/D with the number n of points. The error includes the spread
        between eight groups of walkers, and the difference between all walkers and a group, whose scales are coarser.

        Source: Badii & Politi, J. Stat. Phys. 40, 1985, 725-750.
        """
        walkers, _, width = self.states.shape
        groups = np.array_split(np.random.default_rng(1).permutation(walkers), _GROUPS)
        own = np.array([_dimension(self.states[group].reshape(-1, width)) for group in groups])
        whole = _dimension(self.states.reshape(-1, width))
        return whole, float(np.hypot(own.std(ddof=1) / np.sqrt(len(own)), whole - own.mean()))


def chaotic_saddle(
    map: Mapping,
    inside: Inside,
    starts: npt.ArrayLike,
    *,
    life: int,
    length: int = 400,
    walkers: int = 64,
    spread: float = 1e-5,
    seed: int = 1,
) -> ChaoticSaddle:
    """Trajectories that stay near the chaotic saddle in a region, by stagger and step.

    >>> import numpy, gearatlas
    >>> tent = lambda states: 3.0 * numpy.minimum(states, 1.0 - states)
    >>> inside = lambda states: (states[:, 0] >= 0.0) & (states[:, 0] <= 1.0)
    >>> starts = numpy.random.default_rng(1).random((10000, 1))
    >>> saddle = gearatlas.chaotic_saddle(tent, inside, starts, life=18, length=50)
    >>> holes = (saddle.states > 1 / 3 + 1e-4) & (saddle.states < 2 / 3 - 1e-4)
    >>> saddle.states.shape, bool(holes.any())
    ((64, 50, 1), False)

    * `map`: a `CycleMap`, or any function of states (n, d).
    * `inside`: which states are in the region. The region contains no attractor.
    * `starts`: states (n, d) in the region, some of which stay there for `life` applications.
    * `life`: every state of a trajectory stays in the region for this number of applications. Take log(1/`spread`) divided
      by the largest exponent, and ten more.
    * `walkers`, `length`: number of trajectories and of their states, without the first `life` states, which approach the
      saddle.
    * `spread`: standard deviation of displacements, as a part of that of the starts. A displaced state replaces a state
      whose life is too short.

    All displacements have the same scale. The published method prefers small ones. These favour the borders of the gaps
    through which states leave: the exponent of a baker's map is then 1.5 % too large, compared with 0.2 % by chance here.

    Raises `AtlasError` if no start, or no displaced state, stays in the region for `life` applications.

    Source: Sweet, Nusse & Yorke, Phys. Rev. Lett. 86, 2001, 2261-2264.
    """
    random, states = np.random.default_rng(seed), np.array(starts, dtype=np.float64)
    size = states.std(axis=0)
    lasting = states[_lives(map, inside, states, life) >= life]
    if not len(lasting):
        raise AtlasError(f"no start stays in the region for {life} applications; take more starts, or a shorter life")
    now = random.choice(lasting, walkers)
    left, largest, found = _lives(map, inside, now, life + life // 4), 0.0, []
    for step in range(life + length):
        short = np.flatnonzero(left < life)
        for _ in range(_TRIES):
            if not len(short):
                break
            moves = spread * random.normal(size=(len(short), _CANDIDATES, now.shape[1]))
            tried = now[short, np.newaxis] + size * moves
            lives = _lives(map, inside, tried.reshape(-1, now.shape[1]), life + life // 4).reshape(len(short), _CANDIDATES)
            first, rows = (lives >= life).argmax(axis=1), np.arange(len(short))
            good = lives[rows, first] >= life
            now[short[good]], left[short[good]] = tried[rows, first][good], lives[rows, first][good]
            largest = max(largest, float(np.linalg.norm(moves[rows, first][good], axis=1).max(initial=0.0)))
            short = short[~good]
        if len(short):
            raise AtlasError(f"no displaced state stays in the region for {life} applications; take a larger spread")
        if step >= life:
            found.append(now.copy())
        now, left = map(now), left - 1
    return ChaoticSaddle(np.swapaxes(np.array(found), 0, 1), largest)


def _lives(map: Mapping, inside: Inside, states: Floats, most: int) -> npt.NDArray[np.intp]:
    """Applications of the map that states stay in the region, up to a limit; −1 for states outside."""
    lives = np.full(len(states), -1)
    left = np.arange(len(states))
    for n in range(most + 1):
        kept = inside(states)
        left, states = left[kept], states[kept]
        lives[left] = n
        if n == most or not len(left):
            break
        states = map(states)
    return lives


def _dimension(points: Floats) -> float:
    """Dimension from the mean logarithm of the distance to the nearest neighbour, for several numbers of points."""
    counts = np.unique(np.geomspace(len(points) / 32, len(points), 11).astype(int))
    order = np.random.default_rng(1).permutation(len(points))
    probes, others = points[order[: len(points) // 8]], points[order]
    least = np.full((len(probes), len(counts)), np.inf)
    for i, probe in enumerate(probes):
        gaps = np.linalg.norm(others - probe, axis=1)
        gaps[i] = np.inf
        gaps[gaps == 0.0] = np.inf
        nearest = np.minimum.accumulate(gaps)
        least[i] = nearest[counts - 1]
    return float(1.0 / -np.polyfit(np.log(counts - 1), np.log(least).mean(axis=0), 1)[0])

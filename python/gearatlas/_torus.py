"""Invariant circles of the cycle map: motions with two frequencies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ._circle import Circle, turning
from ._errors import AtlasError
from ._map import CycleMap, Floats

_FIRST_NODES = 33
_NEWTON_STEPS = 15
_CONVERGED = 1e-11
_SETTLE, _RECORD = 2000, 4096
"""Iterations of the map before and while an orbit is recorded for the first guess."""
_LEAST_STEP = 1e-3
"""Smallest step of `tori`, as a part of the first one."""


@dataclass(frozen=True)
class Torus:
    """An invariant circle x(θ) of the cycle map P with P(x(θ)) = x(θ + ρ). Angles are in turns."""

    map: CycleMap
    """The map that leaves the circle invariant."""
    circle: Circle
    """The circle: `circle(angles)` has states (m, 2N)."""
    rotation: float
    """Rotation number ρ: turns per application of the map. ρ, 1 − ρ and ρ + 1 describe the same motion."""
    residual: float
    """Largest distance between P(x(θ)) and x(θ + ρ) halfway between nodes, in half gaps of the energy norm."""
    error: float
    """Largest distance from the circle with half the nodes, in the same unit."""
    rotation_error: float
    """Distance from the rotation number with half the nodes; 0 if the rotation number was given."""

    def distance(self, states: npt.ArrayLike) -> Floats:
        """Distances of states (m, 2N) from the circle, in half gaps of the energy norm, (m,)."""
        weighted, weights = self.map.weighted_components, self.map.weights[self.map.weighted_components]
        points = np.atleast_2d(np.asarray(states, dtype=np.float64))[:, weighted]
        fine = 8 * len(self.circle)
        curve = self.circle.refined(fine).nodes[:, weighted]
        nearest = np.array([np.linalg.norm(weights * (curve - point), axis=1).argmin() for point in points]) / fine
        low, high = nearest - 1.0 / fine, nearest + 1.0 / fine
        golden = 0.5 * (np.sqrt(5.0) - 1.0)
        for _ in range(40):
            inner = high - golden * (high - low), low + golden * (high - low)
            gaps = [np.linalg.norm(weights * (self.circle(at)[:, weighted] - points), axis=1) for at in inner]
            left = gaps[0] < gaps[1]
            low, high = np.where(left, low, inner[0]), np.where(left, inner[1], high)
        return np.asarray(np.minimum(*gaps))


def torus(
    map: CycleMap,
    start: npt.ArrayLike | Torus,
    *,
    rotation: float | None = None,
    free: str | None = None,
    tolerance: float = 1e-4,
    most: int = 543,
) -> Torus:
    """The invariant circle near a motion with two frequencies, stable or not, by Newton's method.

    >>> import gearatlas
    >>> map = gearatlas.CycleMap(gearatlas.load("manifests/oscillators/flutter.toml").point())
    >>> found = gearatlas.torus(map, map.start(), tolerance=1e-3)
    >>> far = map(found.circle(0.3), 100)
    >>> round(found.rotation, 4), bool(found.distance(far)[0] < found.error < 1e-3)
    (0.3447, True)

    * `start`: a state whose motion settles on the circle, or a circle nearby.
    * `rotation`: the rotation number. The default is that of `start` if a key is free, else it is found.
    * `free`: a key of the manifest, whose value is found. `Torus.map` has the result. Circles with a given rotation number
      exist along curves in a plane of two keys.
    * `tolerance`: of the states, in half gaps of the energy norm. The number of nodes is doubled until they change less.
    * `most`: largest number of nodes. `Torus.error` has the error that was reached.

    The circle is a trigonometric polynomial with n nodes. The equations hold at the nodes, and one more fixes the phase. A
    contact that closes at the start of a cycle leaves a circle with a step in the second derivative (in the first, if the
    contact has damping). The error then falls with a power of n only.

    Raises `AtlasError` if there is no such circle, as for a periodic or chaotic motion.

    Source: Schilder, Osinga & Vogt, SIAM J. Appl. Dyn. Syst. 4, 2005, 459-488. The first guess has weighted averages along
    the motion (Das et al., Nonlinearity 30, 2017, 4111-4140).
    """
    equations = _Equations(map, free)
    if isinstance(start, Torus):
        circle, found = start.circle, start.rotation
    else:
        circle, found = _guessed(map, np.array(start, dtype=np.float64))
    given = found if rotation is None else rotation
    value = found if free is None else map.point[free]
    circle, value = equations.solved(circle, given, value)
    error, change = np.inf, np.inf
    while error > tolerance and 2 * len(circle) + 1 <= most:
        finer = circle.refined(2 * len(circle) + 1)
        refined, refined_value = equations.solved(finer, given, value)
        error, change = float(equations.size(refined.nodes - finer.nodes).max()), abs(refined_value - value)
        circle, value = refined, refined_value
    turned, own = (value, map) if free is None else (given, map.at({free: value}))
    return Torus(own, circle, turned, equations.residual(own, circle, turned), error, change if free is None else 0.0)


def tori(
    start: Torus,
    over: str,
    to: float,
    *,
    free: str | None = None,
    step: float | None = None,
    tolerance: float = 1e-4,
    most: int = 543,
) -> list[Torus]:
    """Follows a circle over a key of the manifest, from its value up or down to `to`.

    With a `free` key the rotation number stays that of `start`. Without one the rotation number varies with the key. The
    circle then ends before a locked motion, where the rotation number becomes a simple fraction.

    * `step`: first and largest step of the key, 1/20 of the way by default. It is halved down to a thousandth if Newton's
      method fails or the circle would need more than `most` nodes. The list ends there if it does not reach `to`.

    `tolerance` is that of `torus`. All circles in the list meet it.
    """
    at = float(start.map.point[over])
    largest = abs(to - at) / 20.0 if step is None else step
    length, found, sign = largest, [start], np.sign(to - at)
    while sign * (to - at) > 0.0:
        target = at + sign * min(length, abs(to - at))
        if abs(to - target) < 1e-9 * largest:
            target = to
        try:
            following = torus(
                found[-1].map.at({over: target}),
                _ahead(found, over, target),
                free=free,
                tolerance=tolerance,
                most=most,
            )
            if not following.error <= tolerance:
                raise AtlasError("the circle needs more nodes")
        except AtlasError:
            length *= 0.5
            if length < _LEAST_STEP * largest:
                break
            continue
        found.append(following)
        at, length = target, min(1.5 * length, largest)
    return found


def _ahead(found: Sequence[Torus], over: str, target: float) -> Torus:
    """A first guess at a value of a key, extrapolated from the last two circles."""
    last = found[-1]
    count = max(_FIRST_NODES, (len(last.circle) // 4) | 1)
    circle, rotation = last.circle.refined(count), last.rotation
    if len(found) > 1:
        before = found[-2]
        share = (target - last.map.point[over]) / (last.map.point[over] - before.map.point[over])
        circle = Circle(circle.nodes + share * (circle.nodes - before.circle.refined(count).nodes))
        rotation += share * (last.rotation - before.rotation)
    return replace(last, circle=circle, rotation=rotation)


class _Equations:
    """x(θ + ρ) = P(x(θ)) at the nodes, and one equation for the phase, in half gaps of the energy norm."""

    def __init__(self, map: CycleMap, free: str | None) -> None:
        self.map, self.free = map, free
        self.weighted, self.weights = map.weighted_components, map.weights[map.weighted_components]
        self.cycles = _cycles(map)

    def size(self, states: Floats) -> Floats:
        sizes: Floats = np.linalg.norm(self.weights * states[:, self.weighted], axis=1)
        return sizes

    def solved(self, start: Circle, rotation: float, value: float) -> tuple[Circle, float]:
        """The circle, and the free value: the rotation number or that of the key."""
        scaled, angles = self.weights * start.nodes[:, self.weighted], start.angles()
        count, width = scaled.shape
        phase = Circle(scaled).derivative(angles)
        phase /= np.linalg.norm(phase)
        nodes, reference = start.nodes.copy(), scaled
        scale = float(np.abs(scaled - scaled.mean(axis=0)).max())
        for _ in range(_NEWTON_STEPS):
            map = self.map if self.free is None else self.map.at({self.free: value})
            rotation = value if self.free is None else rotation
            image = map.image(nodes, self.cycles, jacobian=True, by=[] if self.free is None else [self.free])
            assert image.jacobian is not None
            curve = Circle(scaled)
            off = self.weights * image.states[:, self.weighted] - curve(angles + rotation)
            if not np.isfinite(off).all():
                break
            by = curve.derivative(angles + rotation) if self.free is None else -self.weights * image.by[self.free][:, self.weighted]
            matrix = np.zeros((count * width + 1, count * width + 1))
            blocks = matrix[:-1, :-1].reshape(count, width, count, width)
            rows = np.arange(count)
            for i in range(width):
                blocks[:, i, :, i] = turning(count, rotation)
            blocks[rows, :, rows, :] -= self.weights[:, np.newaxis] * image.jacobian[:, self.weighted][:, :, self.weighted] / self.weights
            matrix[:-1, -1] = by.ravel()
            matrix[-1, :-1] = phase.ravel()
            try:
                change = np.linalg.solve(matrix, np.append(off.ravel(), -(phase * (scaled - reference)).sum()))
            except np.linalg.LinAlgError:
                break
            scaled = scaled + change[:-1].reshape(count, width)
            value += float(change[-1])
            nodes[:, self.weighted] = scaled / self.weights
            size = np.abs(change[:-1]).max()
            if size < _CONVERGED * scale:
                return Circle(nodes), value
            if not size < scale:
                break
        raise AtlasError(
            f"no circle with {count} nodes found; start nearer to a motion with two frequencies, neither locked nor chaotic"
        )

    def residual(self, map: CycleMap, circle: Circle, rotation: float) -> float:
        """Largest distance between P(x(θ)) and x(θ + ρ) halfway between nodes."""
        between = circle.angles() + 0.5 / len(circle)
        return float(self.size(map(circle(between), self.cycles) - circle(between + rotation)).max())


def _cycles(map: CycleMap) -> int:
    """Mesh cycles after which the map repeats."""
    if map.base_period is None:
        raise AtlasError("the map never repeats: an excitation has an order without `cycles = [p, q]`")
    return map.base_period


def _guessed(map: CycleMap, start: Floats) -> tuple[Circle, float]:
    """Circle and rotation number of the motion that a state settles on."""
    cycles, weighted = _cycles(map), map.weighted_components
    state = map(start, _SETTLE * cycles)
    orbit = np.empty((_RECORD, len(state)))
    for i in range(_RECORD):
        orbit[i] = state = map(state, cycles)
    scaled = (map.weights * orbit)[:, weighted]
    if not np.isfinite(scaled).all():
        raise AtlasError("the motion grows without bound; start elsewhere")
    scaled -= scaled.mean(axis=0)
    plane = scaled @ np.linalg.svd(scaled, full_matrices=False)[2][:2].T
    turns = np.angle(plane @ np.array([1.0, 1.0j])) / (2.0 * np.pi)
    # Steps are counted from their circular mean, so that none is near the cut at half a turn.
    middle = np.angle(np.exp(2.0j * np.pi * np.diff(turns)).mean()) / (2.0 * np.pi)
    steps = (np.diff(turns) - middle + 0.5) % 1.0 - 0.5 + middle
    rotation = abs(float(_bump(len(steps)) @ steps))
    order = np.arange(_FIRST_NODES) - _FIRST_NODES // 2
    shape = np.exp(-2.0j * np.pi * rotation * np.outer(order, np.arange(_RECORD)))
    coefficients = (shape * _bump(_RECORD)) @ orbit
    angles = np.arange(_FIRST_NODES) / _FIRST_NODES
    return Circle((np.exp(2.0j * np.pi * np.outer(angles, order)) @ coefficients).real), rotation


def _bump(count: int) -> Floats:
    """Weights exp(−1/(t(1 − t))) of an average, with the sum 1."""
    time = (np.arange(count) + 0.5) / count
    weights = np.exp(-1.0 / (time * (1.0 - time)))
    return np.asarray(weights / weights.sum())

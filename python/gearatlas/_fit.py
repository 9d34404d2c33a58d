"""Fits of keys of a manifest to measured points, by least squares."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import AtlasError, ManifestWarning
from ._manifest import Axis, Changes, load
from ._measured import Floats, Measured, Points, Quantity, measured_points
from ._optional import optional
from ._run import run
from ._sensitivity import sensitivity

# Quantities of `sensitivity` under the name of their column.
_QUANTITIES = {f"harmonics[{order}]": f"deflection_harmonic_{order}" for order in (1, 2, 3)}
# Smallest and largest step of differences, relative to the size of a key. The smallest is for values without noise.
_STEPS = (1e-4, 0.05)
# Relative difference above which `sensitivity` has found another motion than the computed one.
_OTHER_MOTION = 1e-3
# Smallest singular value of the scaled Jacobian, relative to the largest, that determines a combination of keys.
_DETERMINED = 1e-6
# Largest change of the values with a key, relative to both, that may be round-off.
_ROUND_OFF = 1e-7
# Rounds in which the weights are recomputed from the standard errors of the fitted model.
_ROUNDS = 3


@dataclass(frozen=True)
class Fit:
    """Fitted values of keys, k of them, to n measured points. All quantities are in SI."""

    keys: list[str]
    """The keys, (k)."""
    units: list[str]
    """Their SI units, (k)."""
    values: Floats
    """Their fitted values, (k,)."""
    covariance: Floats
    """Covariance of the values, `(JᵀWJ)⁻¹` with the Jacobian J and the weights W at the fitted values, (k, k)."""
    axis: Floats
    """Values of the axis at the measured points, (n,)."""
    measured: Floats
    """The measured values, (n,)."""
    computed: Floats
    """The values that the fitted drive gives there, (n,)."""
    stderr: Floats
    """Standard error of each residual, of the measured and of the computed value together, (n,)."""
    jacobian: Floats
    """Derivatives of the computed values by the keys, (n, k)."""
    known_errors: bool
    """Whether the measured points have standard errors. Otherwise they are estimated from the residuals."""
    evaluations: int
    """Number of computed curves."""
    _problem: _Problem

    @property
    def residuals(self) -> Floats:
        """Measured minus computed values, (n,)."""
        return self.measured - self.computed

    @property
    def chi_squared(self) -> float:
        """Sum of the squares of residuals over their standard errors; about `freedoms` for a model that fits."""
        return float(np.sum((self.residuals / self.stderr) ** 2))

    @property
    def freedoms(self) -> int:
        """n - k."""
        return len(self.measured) - len(self.keys)

    @property
    def errors(self) -> Floats:
        """Standard error of each value, (k,)."""
        return np.sqrt(np.diag(self.covariance))

    def intervals(self, level: float = 0.95) -> Floats:
        """The interval of each single value, (k, 2)."""
        stats = optional("scipy.stats", "scipy")
        tail = 0.5 * (1 + level)
        quantile = stats.norm.ppf(tail) if self.known_errors else stats.t.ppf(tail, self.freedoms)
        half = quantile * self.errors
        return np.stack([self.values - half, self.values + half], axis=1)

    def distance(self, values: Mapping[str, float]) -> float:
        """Squared distance `(p - p̂)ᵀ C⁻¹ (p - p̂)` of values of all keys from the fitted ones, with the covariance C."""
        off = np.array([values[key] for key in self.keys]) - self.values
        return float(off @ np.linalg.solve(self.covariance, off))

    def inside(self, values: Mapping[str, float], level: float = 0.95) -> bool:
        """Whether values of all keys are in the joint region of this level: an ellipsoid whose squared radius is a quantile
        of χ² with k degrees of freedom, or k times one of F with k and n - k if the standard errors are estimated."""
        stats = optional("scipy.stats", "scipy")
        k = len(self.keys)
        limit = stats.chi2.ppf(level, k) if self.known_errors else k * stats.f.ppf(level, k, self.freedoms)
        return self.distance(values) <= float(limit)

    def plot(self, axes: Any = None) -> Any:
        """Draws the measured points with their standard errors and the fitted curve over the grid of the manifest, in the
        units of the measured points. Returns the axes of Matplotlib."""
        if axes is None:
            axes = optional("matplotlib.pyplot", "matplotlib").subplots()[1]
        problem = self._problem
        of_axis, of_value = problem.measured.axis, problem.measured.value
        across, up = of_axis.factor(problem.axis.unit), of_value.factor(problem.unit)
        grid = np.unique(np.concatenate([problem.axis.values, self.axis]))
        curve, _ = problem.curve(self.values, grid)
        axes.plot(grid / across, curve / up, label="fitted")
        bars = None if problem.errors is None else problem.errors / up
        axes.errorbar(self.axis / across, self.measured / up, bars, fmt="ko", markersize=4, label="measured")
        axes.set_xlabel(f"{of_axis.name} [{of_axis.unit or problem.axis.unit}]")
        axes.set_ylabel(f"{of_value.name} [{of_value.unit or problem.unit}]")
        axes.legend()
        return axes

    def __repr__(self) -> str:
        told = zip(self.keys, self.values, self.errors, self.units)
        values = ", ".join(f"{key} = {value:.6g} ± {error:.2g} {unit}" for key, value, error, unit in told)
        return f"<gearatlas.Fit {values}; χ² {self.chi_squared:.3g} of {self.freedoms} freedoms>"


class _Problem:
    """A manifest, measured points, and the keys to be fitted."""

    def __init__(
        self,
        manifest: str | os.PathLike[str] | Mapping[str, Any],
        measured: Measured,
        keys: Sequence[str] | Mapping[str, float | str],
        column: str | None,
        changes: Changes,
        options: dict[str, Any],
    ) -> None:
        self.manifest, self.measured, self.changes, self.options = manifest, measured, dict(changes), options
        self.job = load(manifest, changes)
        self.column = column or measured.value.name
        self.axis = self._axis()
        self.places = measured.axis.in_si(self.axis.unit)
        low, high = self.axis.values.min(), self.axis.values.max()
        # The numbers of a file are rounded.
        slack = 1e-4 * (high - low)
        outside = self.places[(self.places < low - slack) | (self.places > high + slack)]
        if outside.size:
            raise AtlasError(
                f"measured points at {self.axis.name} = {outside[0]:g} {self.axis.unit} are outside the grid, which goes from "
                f"{low:g} to {high:g}; extend grid.{self.axis.name}, or remove them"
            )
        self.keys = list(keys)
        if not self.keys or len(set(self.keys)) < len(self.keys):
            raise AtlasError("give at least one key to fit, each once")
        # Load and torque are one quantity; the grid has one of them.
        axes = [axis.name for axis in self.job.axes]
        known = [key for key in self.job.keys if key not in ("load", "torque") or key in axes]
        if unknown := [key for key in self.keys if key not in known]:
            raise AtlasError(f"`{unknown[0]}` cannot be fitted; the keys of this manifest are {', '.join(known)}")
        if self.axis.name in self.keys:
            raise AtlasError(f"`{self.axis.name}` is the axis of the measured points and cannot be fitted")
        point = self.job.point(0, keys if isinstance(keys, Mapping) else None)
        self.start = np.array([point[key] for key in self.keys])
        self.units = [point.unit(key) for key in self.keys]
        # Keys are fitted as multiples of these.
        self.sizes = np.where(self.start == 0, 1.0, np.abs(self.start))
        self.evaluations = 0
        self.unit = ""
        self.first = self.curve(self.start, self.places)
        self.values = measured.value.in_si(self.unit)
        self.errors = measured.stderr.in_si(self.unit) if measured.stderr is not None else None
        if self.errors is not None and (self.errors == 0).any():
            raise AtlasError("a measured point has the standard error 0; give its error, or remove the column")
        spare = 0 if self.errors is not None else 1
        if len(self.values) < len(self.keys) + spare:
            raise AtlasError(
                f"{len(self.values)} measured points do not determine {len(self.keys)} keys"
                + (" and their own standard error" if spare else "")
                + "; fit fewer keys, or measure more points"
            )

    def _axis(self) -> Axis:
        """The axis of the measured points, the only one with several values."""
        name = self.measured.axis.name
        axes = {axis.name: axis for axis in self.job.axes}
        if name not in axes:
            raise AtlasError(f"the grid has no axis `{name}`, over which the points were measured; its axes are {', '.join(axes)}")
        for other, axis in axes.items():
            if other != name and len(axis.values) > 1:
                raise AtlasError(f"the grid has {len(axis.values)} values of `{other}`; keep the one of the measurement: set={{'grid.{other}': ...}}")
        return axes[name]

    def changes_of(self, values: Floats) -> dict[str, Any]:
        """Changes of the manifest that give the keys these values."""
        of_grid = {"load", "torque", "speed"}
        return {f"grid.{key}" if key in of_grid else key: float(value) for key, value in zip(self.keys, values)}

    def curve(self, values: Floats, places: Floats) -> tuple[Floats, Floats]:
        """The column and its standard errors at places of the axis, (n,) each."""
        grid, order = np.unique(places, return_inverse=True)
        changes = {**self.changes, f"grid.{self.axis.name}": {"values": grid.tolist()}, **self.changes_of(values)}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ManifestWarning)
            results = run(self.manifest, set=changes, progress=False, **self.options)
        points = results.points
        self.evaluations += 1
        base = self.column.partition("[")[0]
        if not (points.units.get(self.column) or points.units.get(base)):
            known = [own for own in points.columns if points.units[own]]
            raise AtlasError(f"the results have no column of numbers `{base}`; they have {', '.join(known)}")
        try:
            found, self.unit = points.single(self.column), points.unit(self.column)
        except (KeyError, ValueError) as error:
            raise AtlasError(f"`{self.column}` is not a single column; name an element of a list as in harmonics[1], counted from 1") from error
        own = points.stderr(self.column)
        own = np.zeros_like(found) if own is None else own
        rank = np.argsort(points[self.axis.name], kind="stable")
        if len(rank) != len(grid):
            raise AtlasError("the manifest computes several results per point; set grid.order to a single direction")
        found, own = found[rank][order], np.nan_to_num(own[rank][order])
        if (missing := np.isnan(found)).any():
            raise AtlasError(
                f"{self.column} has no value at {self.axis.name} = {places[missing][0]:g} {self.axis.unit} with "
                + ", ".join(f"{key} = {value:g} {unit}" for key, value, unit in zip(self.keys, values, self.units))
                + "; give bounds for the keys, or remove the point"
            )
        return found, own

    def jacobian(self, values: Floats, computed: Floats, noise: Floats) -> Floats:
        """Derivatives of the computed values by the keys, (n, k): those of `sensitivity` if it gives them for the same
        motion, else central differences."""
        by = np.full((len(self.places), len(self.keys)), np.nan)
        quantity = _QUANTITIES.get(self.column, self.column)
        for place in np.unique(self.places):
            here = self.places == place
            point = self.job.point(0, {self.axis.name: place, **dict(zip(self.keys, values))})
            try:
                rows = sensitivity(point, self.keys, tables=self.options["tables"]).rows.to_dicts()
            except AtlasError:
                continue
            for row in rows:
                value, error = computed[here][0], noise[here][0]
                same = row["quantity"] == quantity and abs(row["value"] - value) <= _OTHER_MOTION * abs(value) + 5 * error
                if same and row["derivative"] is not None and not row["note"]:
                    by[here, self.keys.index(row["key"])] = row["derivative"]
        for key in np.flatnonzero(np.isnan(by).any(axis=0)).tolist():
            lost = np.isnan(by[:, key])
            by[lost, key] = self._difference(key, values, computed, noise)[lost]
        return by

    def _difference(self, key: int, values: Floats, computed: Floats, noise: Floats) -> Floats:
        """Central differences by a key. The relative step is the cube root of the relative noise, which balances the
        errors from noise and from curvature."""
        relative = np.median(noise / np.maximum(np.abs(computed), np.finfo(float).tiny))
        step = self.sizes[key] * float(np.clip(np.cbrt(relative), *_STEPS))
        ends = []
        for sign in (-1, 1):
            near = values.copy()
            near[key] += sign * step
            ends.append(self.curve(near, self.places)[0])
        return np.asarray((ends[1] - ends[0]) / (2 * step))

    def check_determined(self, weighted: Floats, relative: Floats) -> None:
        """Raises `AtlasError` if the weighted Jacobian by relative keys, (n, k), does not determine all combinations of
        keys, or if a derivative of the values by relative keys, relative to the largest value, is round-off."""
        for key, changes in zip(self.keys, np.abs(relative).max(axis=0)):
            if not changes > _ROUND_OFF:
                raise AtlasError(
                    f"the measured points do not determine `{key}`: {self.column} does not change with it there; fit fewer "
                    "keys, or add points that depend on it"
                )
        _, singular, directions = np.linalg.svd(weighted, full_matrices=False)
        if singular[-1] > _DETERMINED * singular[0]:
            return
        open_keys = [key for key, part in zip(self.keys, np.abs(directions[-1])) if part > 0.1]
        told = f"the measured points determine only a combination of `{'`, `'.join(open_keys)}`"
        if len(open_keys) == 1:
            told = f"the measured points do not determine `{open_keys[0]}`"
        raise AtlasError(f"{told}; fit fewer keys, or add points that depend on them")


def fit(
    manifest: str | os.PathLike[str] | Mapping[str, Any],
    measured: Points,
    keys: Sequence[str] | Mapping[str, float | str],
    *,
    column: str | None = None,
    bounds: Mapping[str, tuple[Any, Any]] | None = None,
    set: Changes | None = None,
    threads: int | None = None,
    tables: str | os.PathLike[str] = "tables",
    max_evaluations: int = 50,
) -> Fit:
    """Fits keys of a manifest to measured points by weighted least squares (`scipy.optimize.least_squares`).

    * `manifest`: a path, a text or a dictionary, as for `load`. One axis of its grid has several values.
    * `measured`: a file as for `atlas plot --measured`, or a mapping of columns in SI: the axis, the value, and perhaps the
      standard error of the value. All points must be within the grid.
    * `keys`: keys on which the drive depends continuously (`Manifest.keys`). A mapping gives their start values, in SI
      or as texts with units; by default these come from the manifest.
    * `column`: column of the points table, or an element of a list such as `harmonics[1]`; by default the name of the value.
    * `bounds`: smallest and largest value of a key, in SI or as quantities of pint; by default a key keeps the sign of its start value.
    * `max_evaluations`: most computed curves of each of at most three rounds.

    A residual has the variance of the measured value plus that of the computed one (the `_stderr` column). The second is
    zero for a motion that settles. Without measured standard errors, all points have the same unknown one. Derivatives are
    those of `sensitivity` for `deflection_mean`, `deflection_rms`, `force_mean`, `force_peak` and `harmonics[1..3]`, if the
    motion has them, and otherwise differences.

    The problem is not convex. A start value on the other side of a resonance may lead to a different minimum.

    Raises `AtlasError` for an unknown key or column, too few points, points outside the grid, or keys that the points do
    not determine, and `ManifestError` for a faulty manifest or file.
    """
    optimize = optional("scipy.optimize", "scipy")
    options = {"threads": threads, "tables": tables}
    problem = _Problem(manifest, measured_points(measured), keys, column, set or {}, options)
    sizes = problem.sizes
    low = np.where(problem.start > 0, 0.0, -np.inf)
    high = np.where(problem.start < 0, 0.0, np.inf)
    units = dict(zip(problem.keys, problem.units))
    for key, ends in (bounds or {}).items():
        smallest, largest = (float(Quantity.of(key, end).in_si(units.get(key, ""))) for end in ends)
        if key not in problem.keys or not smallest < largest:
            raise AtlasError(f"the bounds of `{key}` are not those of a fitted key, from low to high")
        low[problem.keys.index(key)], high[problem.keys.index(key)] = smallest, largest
    if ((problem.start <= low) | (problem.start >= high)).any():
        raise AtlasError("the start values must be inside the bounds")
    values = problem.start
    computed, noise = problem.first
    sigma = _sigma(problem, computed, noise)
    known: dict[bytes, tuple[Floats, Floats]] = {values.tobytes(): (computed, noise)}

    def at(relative: Floats) -> tuple[Floats, Floats, Floats]:
        own = relative * sizes
        if own.tobytes() not in known:
            known.clear()
            known[own.tobytes()] = problem.curve(own, problem.places)
        return own, *known[own.tobytes()]

    def residuals(relative: Floats) -> Floats:
        return np.asarray((at(relative)[1] - problem.values) / sigma)

    def jacobian(relative: Floats) -> Floats:
        own, computed, noise = at(relative)
        by = np.asarray(problem.jacobian(own, computed, noise) * sizes)
        problem.check_determined(by / sigma[:, None], by / np.abs(computed).max())
        return by / sigma[:, None]

    for _ in range(_ROUNDS):
        found = optimize.least_squares(
            residuals, values / sizes, jacobian, (low / sizes, high / sizes), xtol=1e-7, ftol=1e-7, max_nfev=max_evaluations
        )
        values, computed, noise = at(found.x)
        before, sigma = sigma, _sigma(problem, computed, noise)
        # Equal weights have the same minimum, whatever they are.
        if np.ptp(sigma / before) <= 0.05 * np.median(sigma / before):
            break
    if found.status == 0:
        warnings.warn(f"the fit did not converge in {max_evaluations} evaluations; raise max_evaluations", stacklevel=2)
    if at_bounds := [key for key, active in zip(problem.keys, found.active_mask) if active]:
        warnings.warn(f"the fit ends at a bound of `{'`, `'.join(at_bounds)}`; standard errors do not hold there", stacklevel=2)
    by = found.jac * before[:, None] / sizes
    weighted = by / sigma[:, None]
    return Fit(
        keys=problem.keys,
        units=problem.units,
        values=values,
        covariance=np.linalg.inv(weighted.T @ weighted),
        axis=problem.places,
        measured=problem.values,
        computed=computed,
        stderr=sigma,
        jacobian=by,
        known_errors=problem.errors is not None,
        evaluations=problem.evaluations,
        _problem=problem,
    )


def _sigma(problem: _Problem, computed: Floats, noise: Floats) -> Floats:
    """Standard error of each residual, (n,)."""
    if problem.errors is not None:
        return np.asarray(np.hypot(problem.errors, noise))
    # The unknown variance of the measurement is that of the residuals minus the noise of the computed values.
    freedoms = max(len(computed) - len(problem.keys), 1)
    scatter = (np.sum((computed - problem.values) ** 2) - np.sum(noise**2)) / freedoms
    floor = np.finfo(float).eps * np.max(np.abs(problem.values))
    return np.asarray(np.hypot(np.sqrt(max(scatter, floor**2)), noise))

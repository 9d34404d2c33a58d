"""Statistics over samples: distributions of results from the distributions of a grid."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ._optional import optional
from ._results import Results
from ._table import Table

Array = npt.NDArray[Any]
Column = str | Callable[[Table], Array]
"""A column of `points` by its name, or a function that makes one from the table."""


def quantiles(
    results: Results | Table,
    column: Column,
    q: float | Sequence[float] = (0.05, 0.5, 0.95),
    by: str | Sequence[str] | None = None,
    confidence: float = 0.95,
) -> dict[str, Array]:
    """Quantiles of a column over the samples, with intervals from order statistics (needs SciPy).

    The result has one row per combination of `by` and quantile, with the columns `by`, `q`, `value`, `low`, `high`,
    `samples` and `missing`. `by` has all other axes with several values unless it is given.

    `value` interpolates between samples (`numpy.quantile`). `low` and `high` are samples x(l) and x(u) with
    P(B < l) <= (1 - confidence)/2 and P(B >= u) <= (1 - confidence)/2, where B is binomial with the number of samples and
    q (David & Nagaraja, Order Statistics, 2003, section 7.1). An end that needs more samples is infinite. The interval
    holds for any distribution of independent samples. Samples of the scrambled Sobol' sequence differ less from the
    distribution, so that the interval covers more often. Samples without a value are left out and counted as `missing`.
    """
    binomial = optional("scipy.stats", "scipy").binom
    asked = np.atleast_1d(np.asarray(q, float))
    if not np.all((asked > 0) & (asked < 1)):
        raise ValueError("a quantile must be between 0 and 1")
    tail = _tail(confidence)
    rows = []
    for names, values in _groups(results, column, by):
        known = np.sort(values[~np.isnan(values)])
        ends = np.concatenate(([-np.inf], known, [np.inf]))
        low = ends[binomial.ppf(tail, known.size, asked).astype(int)]
        high = ends[binomial.ppf(1 - tail, known.size, asked).astype(int) + 1]
        middle = np.quantile(known, asked) if known.size else np.full(asked.size, np.nan)
        counts = {"samples": known.size, "missing": values.size - known.size}
        rows += [
            {**names, "q": one, "value": value, "low": least, "high": most, **counts}
            for one, value, least, most in zip(asked, middle, low, high)
        ]
    return _columns(rows)


def rattles(points: Table) -> npt.NDArray[np.float64]:
    """1 if the (first) mesh is out of contact for a part of the time, 0 if it never is, NaN if a point has no NVH
    statistics (`analyses.nvh`)."""
    free = points["fraction_free"]
    return np.where(np.isnan(free), np.nan, (free > 0).astype(float))


def probability(
    results: Results | Table,
    condition: Column = rattles,
    by: str | Sequence[str] | None = None,
    confidence: float = 0.95,
) -> dict[str, Array]:
    """The probability of a condition over the samples, with its Clopper-Pearson interval (needs SciPy).

    `condition` is a column of truth values, or a function of `results.points` that gives truth values or 0, 1 and NaN.
    By default it is rattle, `gearatlas.rattles`. The result has one row per combination of `by`, with the columns `by`,
    `probability`, `low`, `high`, `samples` and `unknown`. `by` has all other axes with several values unless it is given.

    `probability` is the share among the samples with a known condition. The interval of Clopper & Pearson (Biometrika
    26 (1934) 404) holds for independent samples and any probability, including 0 and 1; `quantiles` describes samples
    of a scrambled sequence. Unknown samples count as false for `low` and as true for `high`.
    """
    beta = optional("scipy.stats", "scipy").beta
    tail = _tail(confidence)
    rows = []
    for names, values in _groups(results, condition, by):
        known = values[~np.isnan(values)]
        if not np.isin(known, [0, 1]).all():
            raise ValueError("a condition must give truth values, or 0, 1 and NaN")
        count, true = values.size, int(np.count_nonzero(known))
        most = true + count - known.size
        row = {
            "probability": true / known.size if known.size else np.nan,
            "low": beta.ppf(tail, true, count - true + 1) if true else 0.0,
            "high": beta.ppf(1 - tail, most + 1, count - most) if most < count else 1.0,
        }
        rows.append({**names, **row, "samples": count, "unknown": count - known.size})
    return _columns(rows)


def sobol_indices(
    results: Results | Table,
    column: Column,
    by: str | Sequence[str] | None = None,
    confidence: float = 0.95,
    resamples: int = 1000,
    seed: int = 0,
) -> dict[str, Array]:
    """First-order and total Sobol' indices of a column (needs SALib).

    They are the shares of its variance that each distribution causes alone, and together with the others. The manifest
    must have `grid.design = "saltelli"`. The result has one row per combination of `by` and distribution, with the
    columns `by`, `axis`, `first`, `first_error`, `total`, `total_error`, `samples` and `missing`. An error is half the
    width of the interval, from `resamples` bootstrap samples with `seed`. `SALib.analyze.sobol` computes all four.
    `missing` samples have a row without a value and are left out.
    """
    _tail(confidence)
    analyze = optional("SALib.analyze.sobol", "SALib").analyze
    table = _points(results)
    told = _told(table)
    if told["design"] != "saltelli":
        raise ValueError('Sobol\' indices need grid.design = "saltelli" in the manifest, but these results have "sobol"')
    axes: list[str] = told["axes"]
    step, total = len(axes) + 2, told["samples"]
    rows = []
    for names, places in _places(table, by):
        values = np.full(total * step, np.nan)
        values[table["sample"][places]] = _values(table, column)[places]
        matrix = values.reshape(total, step)
        known = matrix[~np.isnan(matrix).any(axis=1)]
        if len(known) < 2 or np.ptp(known) == 0:
            raise ValueError("the column does not vary over the samples, or lacks values, so it has no sensitivity")
        problem = {"num_vars": len(axes), "names": axes}
        found = analyze(
            problem, known.ravel(), calc_second_order=False, num_resamples=resamples, conf_level=confidence, seed=seed
        )
        rows += [
            {
                **names,
                "axis": axis,
                "first": found["S1"][place],
                "first_error": found["S1_conf"][place],
                "total": found["ST"][place],
                "total_error": found["ST_conf"][place],
                "samples": len(known),
                "missing": total - len(known),
            }
            for place, axis in enumerate(axes)
        ]
    return _columns(rows)


def _tail(confidence: float) -> float:
    if not 0 < confidence < 1:
        raise ValueError("confidence must be between 0 and 1, such as 0.95")
    return (1 - confidence) / 2


def _points(results: Results | Table) -> Table:
    return results.points if isinstance(results, Results) else results


def _told(table: Table) -> dict[str, Any]:
    """The sampling design in the metadata of the table."""
    if "samples" not in table.metadata:
        raise ValueError("these results have no samples: no axis of the manifest's grid is a distribution")
    told: dict[str, Any] = json.loads(table.metadata["samples"])
    return told


def _values(table: Table, column: Column) -> Array:
    if isinstance(column, str) and column not in table.columns:
        raise ValueError(f"the results have no column `{column}`")
    values = table[column] if isinstance(column, str) else np.asarray(column(table))
    if values.dtype == object and all(value is None or isinstance(value, (bool, np.bool_)) for value in values):
        values = np.array([np.nan if value is None else value for value in values], float)
    if values.shape != (table.rows,) or values.dtype.kind not in "bfiu":
        raise ValueError("a column must have one number or truth value per point")
    return values.astype(float)


def _places(table: Table, by: str | Sequence[str] | None) -> Iterator[tuple[dict[str, Any], Array]]:
    """The points of each combination of the values of some columns, with these values."""
    drawn = _told(table)["axes"]
    others = [name for name in json.loads(table.metadata["axes"]) if name not in drawn]
    others += ["direction"] * ("direction" in table.columns)
    varied = [name for name in others if len(set(table[name].tolist())) > 1]
    names = varied if by is None else [by] if isinstance(by, str) else list(by)
    if unknown := [name for name in names if name not in table.columns]:
        raise ValueError(f"the results have no column `{unknown[0]}`")
    if missing := [name for name in varied if name not in names]:
        raise ValueError(f"the points also differ in {', '.join(missing)}; add it to `by`, or leave out `by`")
    keys = list(zip(*(table[name].tolist() for name in names))) if names else [()] * table.rows
    found: dict[tuple[Any, ...], list[int]] = {}
    for place, key in enumerate(keys):
        found.setdefault(key, []).append(place)
    for key, places in found.items():
        yield dict(zip(names, key)), np.array(places)


def _groups(
    results: Results | Table, column: Column, by: str | Sequence[str] | None
) -> Iterator[tuple[dict[str, Any], Array]]:
    """The values of the samples of each group: those of matrix A of a design with several rows per sample."""
    table = _points(results)
    told = _told(table)
    step = told["rows"] // told["samples"]
    values, first = _values(table, column), table["sample"] % step == 0
    for names, places in _places(table, by):
        yield names, values[places[first[places]]]


def _columns(rows: list[dict[str, Any]]) -> dict[str, Array]:
    return {name: np.array([row[name] for row in rows]) for name in rows[0]} if rows else {}

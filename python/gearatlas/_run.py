"""Runs, with their progress in a terminal or a notebook."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from tempfile import TemporaryDirectory
from typing import Any

from . import _gearatlas
from ._manifest import Source, load
from ._results import Results


@dataclass(frozen=True)
class Progress:
    """Where a run stands."""

    done: int
    """Points finished, those taken over from an interrupted run among them."""
    points: int
    """Points of the run, as far as they are known."""
    failed: int
    """Points that failed."""
    not_converged: int
    """Points that did not settle."""
    resumed: int
    """Points taken over from an interrupted run."""
    cycles: int
    """Mesh cycles integrated."""
    elapsed: float
    """Time since the first point was begun [s]."""
    open: bool
    """Whether more points may follow from the results of these, as they do on a refined grid."""


class _Bar:
    """A progress bar of tqdm, if tqdm is installed."""

    def __init__(self, name: str) -> None:
        from tqdm.auto import tqdm

        self._bar = tqdm(desc=name, unit="point", leave=True)

    def __call__(self, progress: Progress) -> None:
        bar = self._bar
        bar.total = progress.points
        # Points of an earlier run say nothing of how fast this one is.
        bar.initial = progress.resumed
        troubles = {"failed": progress.failed, "not settled": progress.not_converged}
        said = {name: count for name, count in troubles.items() if count}
        if said:
            bar.set_postfix(said, refresh=False)
        bar.update(progress.done - bar.n)

    def close(self) -> None:
        self._bar.close()


class _Teller:
    """Tells a callback."""

    def __init__(self, callback: Callable[[Progress], object]) -> None:
        self._callback = callback

    def __call__(self, progress: Progress) -> None:
        self._callback(progress)

    def close(self) -> None:
        pass


def _voice(progress: bool | Callable[[Progress], object], name: str) -> _Bar | _Teller | None:
    if callable(progress):
        return _Teller(progress)
    if not progress:
        return None
    try:
        return _Bar(name)
    except ImportError:
        return None


def run(
    manifest: Source,
    out: str | os.PathLike[str] | None = None,
    *,
    set: dict[str, Any] | None = None,
    threads: int | None = None,
    progress: bool | Callable[[Progress], object] = True,
    overwrite: bool = False,
    max_failures: int | None = None,
    tables: str | os.PathLike[str] = "tables",
) -> Results:
    """Computes the points of a manifest, or continues an interrupted run, as `atlas run` does.

    * `out`: folder of the results. By default, a temporary folder that lives as long as the returned object.
    * `threads`: number of worker threads, by default one per core. The results have the same bits for any number.
    * `progress`: True for a progress bar (if tqdm is installed), False for none, or a function that is called with a
      `Progress` several times per second.
    * `overwrite`: replaces the results in the folder and discards an interrupted run.
    * `max_failures`: stops the run after this many failed points.
    * `tables`: folder of computed tables, a cache.

    Ctrl-C (`KeyboardInterrupt`) ends a run within a fraction of a second. Finished points are kept in the folder. The
    same call, or `atlas run` with the same folder, continues.
    """
    job = load(manifest, set)
    kept = TemporaryDirectory(prefix="atlas-") if out is None else None
    folder = kept.name if kept else os.fspath(out or "")
    voice = _voice(progress, job.name)

    def tell(*numbers: Any) -> None:
        if voice is not None:
            voice(Progress(*numbers))

    def compute() -> None:
        _gearatlas.run(
            job._inner,
            folder,
            threads=threads,
            overwrite=overwrite,
            tables=tables,
            max_failures=max_failures,
            progress=tell if voice is not None else None,
        )

    if voice is None:
        compute()
    else:
        with closing(voice):
            compute()
    results = Results(folder, kept)
    for sentence in results.record["warnings"]:
        warnings.warn(sentence, stacklevel=2)
    return results


def follow(
    manifest: Source,
    out: str | os.PathLike[str] | None = None,
    *,
    set: dict[str, Any] | None = None,
    threads: int | None = None,
    progress: Callable[[str], object] | None = None,
    tables: str | os.PathLike[str] = "tables",
) -> Results:
    """Follows periodic orbits along an axis of the grid and through their bifurcations, as `atlas follow` does.

    The results have the tables `branches`, `bifurcations` and, with a second axis, `curves`. `progress` is called with a
    sentence for every finished line of the grid. Other arguments are those of `run`. After Ctrl-C nothing is written.
    """
    job = load(manifest, set)
    kept = TemporaryDirectory(prefix="atlas-") if out is None else None
    folder = kept.name if kept else os.fspath(out or "")
    _gearatlas.follow(job._inner, folder, threads=threads, tables=tables, progress=progress)
    return Results(folder, kept)

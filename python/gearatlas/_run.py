"""Runs, with their progress in a terminal or a notebook."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from . import _gearatlas
from ._manifest import Changes, Source, load
from ._pint import plain
from ._results import Results, temporary_folder


@dataclass(frozen=True)
class Progress:
    """Progress of a run."""

    done: int
    """Finished points, including those from an interrupted run."""
    points: int
    """Known points of the run."""
    failed: int
    """Points that failed."""
    not_converged: int
    """Points that did not settle."""
    resumed: int
    """Points from an interrupted run."""
    cycles: int
    """Mesh cycles integrated."""
    elapsed: float
    """Time since the start of the first point [s]."""
    open: bool
    """Whether the results of these points may require more points, as on a refined grid."""


class _Bar:
    """A progress bar of tqdm, if tqdm is installed."""

    def __init__(self, name: str) -> None:
        from tqdm.auto import tqdm

        self._bar = tqdm(desc=name, unit="point", leave=True)

    def __call__(self, progress: Progress) -> None:
        bar = self._bar
        bar.total = progress.points
        # Points of an earlier run are irrelevant for the speed of this one.
        bar.initial = progress.resumed
        troubles = {"failed": progress.failed, "not settled": progress.not_converged}
        said = {name: count for name, count in troubles.items() if count}
        if said:
            bar.set_postfix(said, refresh=False)
        bar.update(progress.done - bar.n)

    def close(self) -> None:
        self._bar.close()


class _Teller:
    """Calls a callback."""

    def __init__(self, callback: Callable[[Progress], object]) -> None:
        self._callback = callback

    def __call__(self, progress: Progress) -> None:
        self._callback(progress)

    def close(self) -> None:
        pass


def _folder(out: str | os.PathLike[str] | None) -> tuple[str, TemporaryDirectory[str] | None]:
    """The folder of results, and the object that keeps a temporary folder alive."""
    if out is not None:
        return os.fspath(out), None
    kept = temporary_folder()
    return kept.name, kept


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
    set: Changes | None = None,
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

    >>> import gearatlas
    >>> results = gearatlas.run("manifests/quickstart.toml", set={"grid.load": 0.1}, progress=False)
    >>> results.points["class"].tolist()
    ['periodic', 'periodic', 'chaotic', 'chaotic']
    """
    job = load(manifest, set)
    folder, kept = _folder(out)
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


def sweep(
    manifest: Source,
    axes: Mapping[str, Any] | None = None,
    out: str | os.PathLike[str] | None = None,
    *,
    set: Changes | None = None,
    threads: int | None = None,
    progress: bool | Callable[[Progress], object] = True,
    tables: str | os.PathLike[str] = "tables",
    **more: Any,
) -> Results:
    """Computes a manifest over other axes of its grid, on all cores.

    >>> import gearatlas
    >>> half_gaps = {"mesh.half_gap": ["10 um", "20 um"]}
    >>> results = gearatlas.sweep("manifests/quickstart.toml", half_gaps, load=0.1, speed=[600, 700, 800], progress=False)
    >>> dict(results.to_xarray().sizes)["mesh.half_gap"], results.points.on_grid("lambda_max").shape
    (2, (2, 1, 3))

    * `axes`, and further arguments: values of the axes by their names. An axis is `load`, `torque`, `speed`, or a key of the
      manifest. Values are numbers in SI, texts with units, or quantities of pint: one of them, or a list or array. A mapping
      such as `{"from": 600, "to": 900, "count": 4}` or `{"normal": ["10 um", "1 um"]}` is an axis as in the manifest.
      Other axes keep the values of the manifest.
    * Other arguments are those of `run`.
    """
    chosen = plain({**(axes or {}), **more})
    grid = {f'grid."{name}"': {"values": values} if _several(values) else values for name, values in chosen.items()}
    changes = {**(set or {}), **grid}
    return run(manifest, out, set=changes, threads=threads, progress=progress, tables=tables)


def _several(values: Any) -> bool:
    return isinstance(values, (list, range)) or np.ndim(values) == 1


def follow(
    manifest: Source,
    out: str | os.PathLike[str] | None = None,
    *,
    set: Changes | None = None,
    threads: int | None = None,
    progress: Callable[[str], object] | None = None,
    tables: str | os.PathLike[str] = "tables",
) -> Results:
    """Follows periodic orbits along an axis of the grid and through their bifurcations, as `atlas follow` does.

    The results have the tables `branches`, `bifurcations` and, with a second axis, `curves`. `progress` is called with a
    sentence for every finished line of the grid. Other arguments are those of `run`. After Ctrl-C nothing is written.
    """
    job = load(manifest, set)
    folder, kept = _folder(out)
    _gearatlas.follow(job._inner, folder, threads=threads, tables=tables, progress=progress)
    return Results(folder, kept)

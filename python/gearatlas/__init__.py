"""Gear rattle over grids of operating points, in Python.

>>> import gearatlas
>>> results = gearatlas.run("manifests/quickstart.toml", "results/quickstart", progress=False)
>>> (results.points.on_grid("lambda_max") > 0).astype(int)
array([[0, 0, 1, 1],
       [0, 0, 1, 1],
       [0, 0, 1, 1]])

The manual of the program describes manifests and tables; docs/python.md describes this package.
"""

from ._gearatlas import COMMIT, __version__
from ._border import Border, border
from ._cepstrum import cepstrum
from ._chaos import ChaoticSaddle, Escape, chaotic_saddle, escape
from ._circle import Circle
from ._errors import AtlasError, Fault, ManifestError, ManifestWarning
from ._fit import Fit, fit
from ._manifest import Axis, Manifest, Point, load
from ._manifold import manifold, manifold_surface
from ._map import CycleMap, Image
from ._motion import Structure, Trace, structure, trace
from ._results import Results, open
from ._run import Progress, follow, run, sweep
from ._samples import probability, quantiles, rattles, sobol_indices
from ._sensitivity import Sensitivity, sensitivity
from ._table import Table
from ._torus import Torus, tori, torus

__all__ = [
    "COMMIT",
    "AtlasError",
    "Axis",
    "Border",
    "ChaoticSaddle",
    "Circle",
    "CycleMap",
    "Escape",
    "Fault",
    "Fit",
    "Image",
    "Manifest",
    "ManifestError",
    "ManifestWarning",
    "Point",
    "Progress",
    "Results",
    "Sensitivity",
    "Structure",
    "Table",
    "Torus",
    "Trace",
    "__version__",
    "border",
    "cepstrum",
    "chaotic_saddle",
    "escape",
    "fit",
    "follow",
    "load",
    "manifold",
    "manifold_surface",
    "open",
    "probability",
    "quantiles",
    "rattles",
    "run",
    "sensitivity",
    "sobol_indices",
    "structure",
    "sweep",
    "tori",
    "torus",
    "trace",
]

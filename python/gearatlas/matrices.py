"""Linear structures as matrices, with checks.

M u'' + (C + Ω G) u' + (K + K_c) u = f over freedoms u, with the directions along which contacts, loads and
bearings act. Finite-element programs and programs of rotor dynamics export such matrices. `gearatlas.modal_file`
converts them to the modal file that `model.kind = "modal"` reads. All units are SI.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import AtlasError

Vector = npt.NDArray[np.float64]
Matrix = Any
"""A matrix of NumPy, or a sparse one of SciPy."""

MATRICES = ("M", "K", "C", "G", "Kc")
"""Mass, symmetric stiffness, damping, gyroscopic matrix per rad/s of the pinion's speed, cross-coupled
stiffness."""

NUMBERS = ("teeth", "teeth_wheel", "rated_force")

DIRECTIONS = (
    "mesh",
    "torque",
    "mesh_tilt",
    "friction",
    "friction_lever",
    "mesh_coast",
    "mesh_tilt_coast",
    "friction_coast",
    "friction_lever_coast",
    "torque_pinion",
    "torque_wheel",
    "constant_load",
    "load_by_speed",
)
"""Directions over the freedoms, with the names of the resulting columns of the modal file."""

# Round-off of assembly and of a file with seventeen digits, relative to the largest entry.
ROUND_OFF = 1e-9


class StructureError(AtlasError, ValueError):
    """Matrices or directions that do not describe a structure. The message names file and array, the reason and the remedy."""


@dataclass(frozen=True)
class Contact:
    """A one-sided contact in addition to the two flanks of the mesh, or a bearing whose forces are computed."""

    direction: Vector
    """Deflection of a contact per freedom [1]; force on a bearing per freedom [N/m]."""
    second: Vector | None = None
    """Direction of a contact's force if it differs [1]; force of a bearing's dampers per velocity
    [N s/m]."""
    values: Mapping[str, Any] = field(default_factory=dict)
    """Further keys of `[[contact]]`: `gap`, `stiffness`, `levels`, `damping`, `cycles`, ..."""


@dataclass(frozen=True)
class Matrices:
    """A linear structure as matrices over n freedoms; checked on creation.

    Raises `StructureError` if M and K are not square, finite and symmetric, M is not positive definite, G
    is not skew, or sizes do not agree.
    """

    M: Matrix
    """Mass matrix, n by n, dense or sparse."""
    K: Matrix
    """Symmetric stiffness matrix; singular if the structure has rigid-body motions."""
    directions: Mapping[str, Vector]
    """n numbers each; `mesh` and `torque` are required, the others of `DIRECTIONS` are optional."""
    teeth: int
    rated_force: float
    """Mesh force at load 1 [N]."""
    teeth_wheel: int | None = None
    C: Matrix | None = None
    """Damping matrix [N s/m]."""
    G: Matrix | None = None
    """Gyroscopic matrix, skew: a damping per rad/s of the pinion's speed."""
    Kc: Matrix | None = None
    """Unsymmetric stiffness in addition to K: cross-coupling of bearings."""
    contacts: Mapping[str, Contact] = field(default_factory=dict)
    bearings: Mapping[str, Contact] = field(default_factory=dict)
    source: str = "the structure"
    """Its name in messages."""

    def __post_init__(self) -> None:
        for name in MATRICES:
            if getattr(self, name) is not None:
                self._square(name)
        for name in ("M", "K"):
            self._mirrored(name, 1.0, "symmetric", "put the unsymmetric part of a stiffness into `Kc`")
        self._mirrored("G", -1.0, "skew-symmetric", "put damping into `C`")
        low = np.flatnonzero(np.asarray(self.M.diagonal()) <= 0.0)
        if low.size:
            raise self._refused(
                "M",
                f"is not positive definite: freedom {low[0] + 1} has no mass",
                "give it mass, or condense it into the others before the export",
            )
        for name in ("mesh", "torque"):
            if name not in self.directions:
                raise self._refused(name, "is missing", f"give a direction over {self.size} freedoms")
        for name, values in self._all_directions():
            self._direction(name, values)
        if self.teeth < 1 or not self.rated_force > 0.0:
            raise self._refused("teeth and rated_force", "must be above 0", "give the pinion's number of teeth, and the force in newtons")

    @property
    def size(self) -> int:
        """Number of freedoms."""
        return int(self.M.shape[0])

    def _all_directions(self) -> list[tuple[str, Vector]]:
        found = list(self.directions.items())
        for kind, parts in (("contact", self.contacts), ("bearing", self.bearings)):
            for name, part in parts.items():
                found.append((f"{kind}.{name}", part.direction))
                if part.second is not None:
                    found.append((f"{kind}.{name} (second)", part.second))
        return found

    def _refused(self, array: str, why: str, remedy: str) -> StructureError:
        return StructureError(f"{self.source}: `{array}` {why}; {remedy}")

    def _square(self, name: str) -> None:
        matrix = getattr(self, name)
        shape = tuple(getattr(matrix, "shape", ()))
        size = np.shape(self.M)[0] if len(np.shape(self.M)) == 2 else 0
        if len(shape) != 2 or shape[0] != shape[1] or shape[0] == 0:
            raise self._refused(name, f"has the shape {shape}", "give a square matrix")
        if shape[0] != size:
            why = f"is {shape[0]} by {shape[0]}, but `M` is {size} by {size}"
            raise self._refused(name, why, "export all matrices over the same freedoms")
        if np.iscomplexobj(matrix):
            raise self._refused(name, "is complex", "give its real part; structural damping goes into `C`")
        entries = matrix.data if hasattr(matrix, "tocsc") else matrix
        if not np.isfinite(entries).all():
            raise self._refused(name, "has entries that are not finite", "export it again")

    def _mirrored(self, name: str, sign: float, what: str, remedy: str) -> None:
        matrix = getattr(self, name)
        if matrix is None:
            return
        apart, largest = float(abs(matrix - sign * matrix.T).max()), float(abs(matrix).max())
        if apart > ROUND_OFF * largest:
            why = f"is not {what}: entries across the diagonal are up to {apart:.3g} apart"
            raise self._refused(name, why, remedy)

    def _direction(self, name: str, values: Vector) -> None:
        if np.shape(values) != (self.size,):
            why = f"has the shape {np.shape(values)}"
            raise self._refused(name, why, f"give one number per freedom, {self.size} in total")
        if not np.isfinite(values).all():
            raise self._refused(name, "has entries that are not finite", "give 0 where nothing acts")


def spur_mesh(
    base_radii: tuple[float, float], pressure_angle: float, orientation: float = 0.0
) -> dict[str, Vector]:
    """Directions of a spur mesh over (x₁, y₁, θ₁, x₂, y₂, θ₂), the freedoms of pinion and wheel.

    x, y, z are right-handed, and rotations are about z. The direction from the pinion's centre to the wheel's has the
    angle `orientation` to x. Rotating the pinion by θ₁ > 0 closes the drive flanks. With the direction c to the wheel's
    centre and t = z × c, the drive flanks of the pinion push along n = cos α t + sin α c, and

        δ = n (u₁ − u₂) + r₁ θ₁ + r₂ θ₂,

    with the base radii r [m] and the operating pressure angle α [rad]. Coast flanks act along cos α t − sin α c. A unit
    friction force acts on the pinion along cos α c − sin α t.
    """
    sin, cos = float(np.sin(pressure_angle)), float(np.cos(pressure_angle))
    along = np.array([np.cos(orientation), np.sin(orientation)])
    across = np.array([-along[1], along[0]])
    first, second = base_radii

    def pair(direction: Vector, turn_first: float, turn_second: float) -> Vector:
        return np.concatenate([direction, [turn_first], -direction, [turn_second]])

    # A force on the pinion at its pitch point has the lever r/cos α.
    levers = [-first * sin / cos, -second * sin / cos]
    still = np.zeros(2)
    return {
        "mesh": pair(cos * across + sin * along, first, second),
        "mesh_coast": pair(cos * across - sin * along, first, second),
        "friction": pair(cos * along - sin * across, *levers),
        "friction_lever": pair(still, -1.0, 1.0),
        "friction_coast": pair(-cos * along - sin * across, *levers),
        "friction_lever_coast": pair(still, 1.0, -1.0),
    }

"""What is a linear structure as matrices, and is it one?

M u'' + (C + Ω G) u' + (K + K_c) u = f over freedoms u, with the directions along which contacts, loads and
bearings act: what finite-element codes and programs of rotor dynamics export. `gearatlas.modal_file` makes the
modal file of it that `model.kind = "modal"` reads. SI throughout.
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
"""Mass, symmetric stiffness, damping, gyroscopic matrix by rad/s of the pinion's speed, cross-coupled
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
"""Directions over the freedoms, named as the columns of the modal file that they become."""

# Of the largest entry: what assembly and a file of seventeen digits leave.
ROUND_OFF = 1e-9


class StructureError(AtlasError, ValueError):
    """Matrices or directions that do not describe a structure. The message names file and array, the reason and the remedy."""


@dataclass(frozen=True)
class Contact:
    """A one-sided contact beside the two flanks of the mesh, or a bearing whose forces are computed."""

    direction: Vector
    """Deflection of a contact by the freedoms [1]; force on a bearing by the freedoms [N/m]."""
    second: Vector | None = None
    """Direction of a contact's force where that is another [1]; force of a bearing's dampers by the
    velocities [N s/m]."""
    values: Mapping[str, Any] = field(default_factory=dict)
    """Further keys of `[[contact]]`: `gap`, `stiffness`, `levels`, `damping`, `cycles`, ..."""


@dataclass(frozen=True)
class Matrices:
    """A linear structure as matrices over n freedoms; checked where it is made.

    Raises `StructureError` where M and K are not square, finite and symmetric, M is not positive definite, G
    is not skew, or sizes do not agree.
    """

    M: Matrix
    """Mass matrix, n by n, dense or sparse."""
    K: Matrix
    """Symmetric stiffness matrix; singular where the structure moves as a rigid body."""
    directions: Mapping[str, Vector]
    """n numbers each; `mesh` and `torque` are required, others are those of `DIRECTIONS`."""
    teeth: int
    rated_force: float
    """Mesh force at load 1 [N]."""
    teeth_wheel: int | None = None
    C: Matrix | None = None
    """Damping matrix [N s/m]."""
    G: Matrix | None = None
    """Gyroscopic matrix, skew: a damping by rad/s of the pinion's speed."""
    Kc: Matrix | None = None
    """Stiffness that is not symmetric, on top of K: cross-coupling of bearings."""
    contacts: Mapping[str, Contact] = field(default_factory=dict)
    bearings: Mapping[str, Contact] = field(default_factory=dict)
    source: str = "the structure"
    """Where it comes from, as messages call it."""

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
        """How many freedoms there are."""
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

    x, y, z are right-handed, rotations about z; the wheel's centre lies from the pinion's at the angle
    `orientation` to x. Turning the pinion by θ₁ > 0 closes the drive flanks. With c the direction to the wheel's
    centre, t = z × c, the drive flanks of the pinion push along n = cos α t + sin α c and

        δ = n (u₁ − u₂) + r₁ θ₁ + r₂ θ₂,

    r the base radii [m], α the operating pressure angle [rad]. Coast flanks lie along cos α t − sin α c. A unit
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

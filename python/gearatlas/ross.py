"""Two rotors of ROSS (`pip install ross-rotordynamics`) and a spur mesh between them, as matrices.

    from gearatlas.modal_file import write
    from gearatlas.ross import geared
    write(geared((pinion, wheel), nodes=(2, 1), teeth=(20, 30), base_radii=(0.0376, 0.0564),
                 pressure_angle=0.349, rated_torque=50.0), "drive.modal.toml", modes=40)

A `ross.Rotor` with six freedoms per node has, node by node, x, y, z, α, β, θ: displacements, rotations about x, about y
and about its axis z, all right-handed; links of bearings follow. `ross.MultiRotor` is not used, because it closes the
mesh permanently by a spring, and counts the wheel's rotation against its axis. Give its rotors before they are joined.
This module does not import ROSS: any object with the methods of a rotor is accepted.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .matrices import Contact, Matrices, StructureError, Vector, spur_mesh

FREEDOMS = 6
X, Y, Z, TURN = 0, 1, 2, 5


def geared(
    rotors: tuple[Any, Any],
    *,
    nodes: tuple[int, int],
    teeth: tuple[int, int],
    base_radii: tuple[float, float],
    pressure_angle: float,
    rated_torque: float,
    orientation: float = 0.0,
    ends: tuple[int, int] | None = None,
    speed: float = 0.0,
    axial: bool = False,
) -> Matrices:
    """The rotors of pinion and wheel, with a spur mesh between them that opens and closes.

    * `nodes`: nodes of the gears; their masses and inertias are in the rotors, as `DiskElement` or `GearElement`.
    * `base_radii` [m], `pressure_angle` [rad] (the operating one), `orientation`: angle from x to the wheel's
      centre [rad], the same x for both rotors.
    * `rated_torque`: torque on the pinion at load 1 [N m]. It acts at the nodes `ends` (by default the first nodes),
      and its counterpart acts on the wheel.
    * `speed`: pinion speed for the coefficients of bearings [rad/s].
    * `axial`: keeps axial motion, which a spur mesh does not excite; otherwise z is fixed.

    Gyroscopic terms are proportional to the speed; those of the wheel have the opposite sign and the ratio of teeth as
    a factor. The unsymmetric part of the bearings' stiffness becomes K_c. Forces on bearings along x and y become
    `bearings`. Raises `StructureError`.
    """
    ratio = teeth[0] / teeth[1]
    if not np.isclose(base_radii[0] / base_radii[1], ratio, rtol=1e-3):
        raise StructureError(f"base radii {base_radii} do not match the teeth {teeth}, whose ratio is {ratio:g}; correct one of them")
    for rotor in rotors:
        if rotor.number_dof != FREEDOMS:
            raise StructureError(f"a rotor has {rotor.number_dof} freedoms per node; use elements of ROSS with 6")
    turns = (1.0, -ratio)
    sizes = [rotor.ndof for rotor in rotors]
    at = [0, sizes[0]]
    frequencies = [abs(turn) * speed for turn in turns]
    stiffness = _joined([rotor.K(frequency) for rotor, frequency in zip(rotors, frequencies)])
    symmetric = (stiffness + stiffness.T) / 2
    crossed = stiffness - symmetric
    kept = np.ones(sum(sizes), dtype=bool)
    if not axial:
        for start, rotor in zip(at, rotors):
            kept[start + Z : start + FREEDOMS * len(rotor.nodes) : FREEDOMS] = False
            for places in _links(rotor):
                kept[start + places[Z]] = False

    def place(which: int, node: int, freedom: int) -> int:
        return int(at[which]) + FREEDOMS * _index(rotors[which], node) + freedom

    def over(entries: Sequence[tuple[int, float]]) -> Vector:
        direction = np.zeros(sum(sizes))
        for index, value in entries:
            direction[index] += value
        return direction[kept]

    gears = [place(which, node, freedom) for which, node in enumerate(nodes) for freedom in (X, Y, TURN)]
    mesh = spur_mesh(base_radii, pressure_angle, orientation)
    directions = {name: over(list(zip(gears, values))) for name, values in mesh.items()}
    ends = ends or (rotors[0].nodes[0], rotors[1].nodes[0])
    shafts = [place(which, node, TURN) for which, node in enumerate(ends)]
    directions["torque"] = over(list(zip(shafts, base_radii)))
    directions["torque_pinion"] = over([(shafts[0], 1.0)])
    # Positive in the wheel's direction of running, as in drives from a drawing.
    directions["torque_wheel"] = over([(shafts[1], -1.0)])
    bearings = {}
    for which, (rotor, frequency) in enumerate(zip(rotors, frequencies)):
        for number, element in enumerate(rotor.bearing_elements, 1):
            places = [at[which] + index for index in element.dof_global_index.values()]
            name = f"{('pinion', 'wheel')[which]} {number}"
            for axis, row in (("x", X), ("y", Y)):
                spring, damper = element.K(frequency)[row], element.C(frequency)[row]
                bearings[f"{name} {axis}"] = Contact(over(list(zip(places, spring))), over(list(zip(places, damper))))

    def cut(matrix: Vector) -> Vector:
        return np.asarray(matrix[np.ix_(kept, kept)])

    mass = _joined([rotor.M(frequency) for rotor, frequency in zip(rotors, frequencies)])
    return Matrices(
        M=cut((mass + mass.T) / 2),
        K=cut(symmetric),
        C=cut(_joined([rotor.C(frequency) for rotor, frequency in zip(rotors, frequencies)])),
        G=cut(_joined([turn * rotor.G() for rotor, turn in zip(rotors, turns)])),
        Kc=cut(crossed) if crossed.any() else None,
        directions=directions,
        teeth=teeth[0],
        teeth_wheel=teeth[1],
        rated_force=rated_torque / base_radii[0],
        bearings=bearings,
        source="two rotors of ROSS",
    )


def _joined(blocks: Sequence[Vector]) -> Vector:
    first, second = blocks
    off = np.zeros((len(first), len(second)))
    return np.block([[first, off], [off.T, second]])


def _index(rotor: Any, node: int) -> int:
    if node not in rotor.nodes:
        raise StructureError(f"a rotor has no node {node}; give one of its nodes, {rotor.nodes[0]} to {rotor.nodes[-1]}")
    return int(list(rotor.nodes).index(node))


def _links(rotor: Any) -> list[list[int]]:
    """Indices of the three freedoms of the supports of bearings."""
    linked = [element for element in rotor.bearing_elements if element.n_link is not None]
    return [list(element.dof_global_index.values())[3:] for element in linked]

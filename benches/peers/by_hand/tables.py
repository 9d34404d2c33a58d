#!/usr/bin/env python3
"""Writes the tables of peer.c for the drive that src/bin/by_hand.rs describes.

    .venv/bin/python benches/peers/by_hand/tables.py CASE.json TABLES

Slots: an amplitude per mode, e^{iωt} and 1; vectors over them have real parts, then imaginary ones. `basis` leads from a
system's amplitudes to the modes, where slot i holds displacement and velocity of mode i. Eigenvectors are refined in
extended precision: plain doubles would leave errors of 3e-11.
"""

import json
import sys
from pathlib import Path

import numpy as np

NODES, SEGMENTS = 8, 3
# Largest angle by which the fastest amplitude turns from node to node (peer.c has terms for half of it), and fewest blocks
# of a cycle.
TURN, FEWEST = 1.0, 3.0
LONG, COMPLEX = np.longdouble, np.clongdouble
SIDES = [1.0, -1.0]

case = json.loads(Path(sys.argv[1]).read_text())
period, half_gap, damper = case["period"], case["half_gap"], case["contact_damping"]
square, damping, load = np.array(case["modes"]).T
flanks = case["flanks"]
M = len(square)
S = M + 2
V = -(-S // 8)
omega = 2 * np.pi / period
assert square[0] == 0 and (square[1:] > 0).all(), "the first mode, and no other, is rigid"


def slots(re: np.ndarray, im: np.ndarray) -> np.ndarray:
    """A padded vector over the amplitudes, along the last axis."""
    out = np.zeros((*re.shape[:-1], 2, 8 * V))
    out[..., 0, :S], out[..., 1, :S] = re, im
    return out.reshape(*re.shape[:-1], 16 * V)


def inverse(a: np.ndarray) -> np.ndarray:
    """Inverse in extended precision, by two steps of Newton's method."""
    x = np.linalg.inv(a.astype(complex if np.iscomplexobj(a) else float)).astype(a.dtype)
    for _ in range(2):
        x = x + x @ (np.eye(len(a)) - a @ x)
    return x


def eigen(a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues above the real axis and their vectors, refined to first order twice."""
    vectors = np.linalg.eig(a.astype(float))[1].astype(COMPLEX)
    for _ in range(3):
        g = inverse(vectors) @ a @ vectors
        values = np.diag(g)
        apart = values[None, :] - values[:, None] + np.eye(len(a))
        vectors = vectors + vectors @ (g * (1 - np.eye(len(a))) / apart)
        vectors /= np.abs(vectors).max(axis=0)
    upper = values.imag > 0
    assert upper.sum() == M, "a system is overdamped"
    return values[upper], vectors[:, upper]


class System:
    """One of the nine linear systems: of each flank 0, open, or 1 + its level."""

    def __init__(self, states: tuple[int, int]):
        a = np.zeros((2 * M, 2 * M), LONG)
        a[:M, M:] = np.eye(M)
        a[M:, :M], a[M:, M:] = -np.diag(square), -np.diag(damping)
        constant, driven = np.zeros(2 * M, LONG), np.zeros(2 * M, COMPLEX)
        constant[M:] = load
        for flank, side, state in zip(flanks, SIDES, states):
            if state:
                w, g, k = np.array(flank["w"]), np.array(flank["g"]), levels(flank)[state - 1]
                a[M:, :M] -= k * np.outer(g, w)
                a[M:, M:] -= damper * np.outer(g, w)
                constant[M:] += k * side * half_gap * g
                driven[M:] += (k + 1j * omega * damper) * wave(flank) * g
        self.free = not any(states)
        # Velocities by a frequency are of the size of displacements.
        scale = np.concatenate([np.full(M, 2.5e4), np.ones(M)])
        if self.free:
            decay = -0.5 * damping
            rates = decay + 1j * np.sqrt(np.maximum(square - decay**2, 0))
            vectors = np.zeros((2 * M, M), COMPLEX)
            vectors[:M], vectors[M:] = np.eye(M), np.diag(rates)
            vectors[M, 0] = -1j  # the rigid mode's imaginary part is its velocity
            at_rest = np.concatenate([[0], load[1:] / square[1:], np.zeros(M)])
        else:
            rates, vectors = eigen(scale[:, None] * a / scale)
            vectors = vectors / scale[:, None]
            vectors /= np.abs(vectors[:M]).max(axis=0)
            at_rest = -(inverse(scale[:, None] * a / scale) @ (scale * constant)) / scale
        steady = np.eye(2 * M) * 1j * omega - a
        steady = inverse(scale[:, None] * steady / scale) @ (scale * driven) / scale
        self.rates = np.concatenate([rates, [1j * omega, 0]])
        self.basis = np.eye(2 * S, dtype=LONG)
        modal = np.r_[:M, S : S + M]
        columns = np.column_stack([vectors, steady, at_rest])
        self.basis[np.ix_(modal, range(S))] = columns.real
        self.basis[np.ix_(modal, range(S, 2 * S))] = -columns.imag
        # All entries of one size, so that the inverse is well conditioned.
        sizes = np.concatenate([scale[:M], [1, 1], scale[M:], [1, 1]])
        by = np.abs(sizes[:, None] * self.basis).max(axis=0)
        self.back = inverse(sizes[:, None] * self.basis / by) * sizes / by[:, None]
        self.rows = [self.seen(*of) for of in zip(flanks, SIDES, states)]

    def seen(self, flank: dict, side: float, state: int) -> tuple[np.ndarray, ...]:
        """Rows of a flank's margin and of its rate, and what a tangent gains at its event."""
        sign = side if state else -side
        w, u = np.array(flank["w"]), -wave(flank)
        zero = np.zeros(M)
        margin = np.concatenate([w, [u.real, -side * half_gap], zero, [-u.imag, 0]])
        u = 1j * omega * u
        slope = np.concatenate([zero, [u.real, 0], w, [-u.imag, 0]])
        # Closing, the damper's force steps up by c δ'; opening, it steps down.
        salt = (1 if state else -1) * sign * damper * np.array(flank["g"])
        salt = self.back @ np.concatenate([np.zeros(S), salt, [0, 0]])
        return sign * margin @ self.basis, sign * slope @ self.basis, salt

    def arrays(self, step: float) -> list[np.ndarray]:
        """What peer.c reads of it."""
        time = step * np.arange(NODES + 1)
        turns = np.exp(time[:, None] * self.rates[None, :])
        rows = [slots(row[:S], row[S:]) for part in zip(*self.rows) for row in part]
        nodes = np.zeros((S, 4, NODES))
        for f, (row, _, _) in enumerate(self.rows):
            u = (row[:S] - 1j * row[S:])[:, None] * turns[1:].T
            nodes[:, f], nodes[:, 2 + f] = u.real, -u.imag
            if self.free:
                nodes[0, 2 + f] = row[0] * time[1:]
                nodes[-1, f] += row[0] * 0.5 * load[0] * time[1:] ** 2
        return [slots(self.rates.real, self.rates.imag), slots(turns.real, turns.imag), *rows, nodes]


def levels(flank: dict) -> list[float]:
    """Distinct stiffnesses of a flank."""
    found = list(dict.fromkeys(k for _, k in flank["segments"]))
    assert len(found) == 2, "a flank has two levels of stiffness"
    return found


def wave(flank: dict) -> complex:
    """Complex amplitude of a flank's transmission error."""
    amplitude, phase = flank["error"]
    return amplitude * np.exp(1j * phase)


systems = [System((drive, coast)) for drive in range(3) for coast in range(3)]
fastest = max(float(np.abs(system.rates).max()) for system in systems)
blocks = max(np.ceil(period * fastest / (TURN * NODES)), FEWEST)
step = period / (blocks * NODES)

ends, states = [], []
for flank in flanks:
    segments = flank["segments"] + (SEGMENTS - len(flank["segments"])) * [flank["segments"][-1]]
    ends += [period * end for end, _ in segments]
    states += [1 + levels(flank).index(k) for _, k in segments]
header = np.zeros(24)
header[:17] = [V, S, period, step, load[0], *ends, *states]

eye = np.eye(2 * S, dtype=LONG)
bases = [(system.basis, system.back) for system in systems] + [(eye, eye)]
with Path(sys.argv[2]).open("wb") as file:
    header.tofile(file)
    for system in systems:
        for array in system.arrays(step):
            array.astype(float).tofile(file)
    for basis, _ in bases:
        for _, back in bases:
            columns = (back @ basis).T[: 2 * S - 1]
            slots(columns[:, :S], columns[:, S:]).tofile(file)

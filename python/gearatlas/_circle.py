"""Closed curves as trigonometric polynomials of an angle, which is counted in turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ._map import Floats


@dataclass(frozen=True)
class Circle:
    """A closed curve x(θ) through states at evenly spaced angles."""

    nodes: Floats
    """States at the angles 0, 1/n, 2/n, ..., (n, d). The number n is odd."""

    def __len__(self) -> int:
        """Number of nodes."""
        return len(self.nodes)

    def __call__(self, angles: npt.ArrayLike) -> Floats:
        """States at angles in turns, (m, d)."""
        return self._summed(self.coefficients(), angles)

    def derivative(self, angles: npt.ArrayLike) -> Floats:
        """Derivatives with respect to the angle in turns, (m, d)."""
        return self._summed(2.0j * np.pi * _orders(len(self))[:, np.newaxis] * self.coefficients(), angles)

    def coefficients(self) -> npt.NDArray[np.complex128]:
        """Coefficients of exp(2πi k θ) for k = 0, 1, ..., −2, −1, (n, d)."""
        return np.asarray(np.fft.fft(self.nodes, axis=0) / len(self))

    def angles(self) -> Floats:
        """The angles of the nodes."""
        return np.linspace(0.0, 1.0, len(self), endpoint=False)

    def refined(self, count: int) -> Circle:
        """The curve with another number of nodes."""
        return Circle(self(np.arange(count) / count))

    def _summed(self, coefficients: npt.NDArray[np.complex128], angles: npt.ArrayLike) -> Floats:
        at = np.atleast_1d(np.asarray(angles, dtype=np.float64))
        states: Floats = (np.exp(2.0j * np.pi * np.outer(at, _orders(len(self)))) @ coefficients).real
        return states


def turning(count: int, rotation: float) -> Floats:
    """The matrix from values at nodes to values at the nodes turned by `rotation`, (n, n)."""
    column = np.fft.ifft(np.exp(2.0j * np.pi * rotation * _orders(count))).real
    matrix: Floats = column[(np.arange(count)[:, np.newaxis] - np.arange(count)) % count]
    return matrix


def _orders(count: int) -> Floats:
    return np.asarray(np.fft.fftfreq(count, 1.0 / count), dtype=np.float64)

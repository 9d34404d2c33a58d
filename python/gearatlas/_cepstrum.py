"""The cepstrum of a signal: how strongly does its spectrum repeat at even distances, as with sidebands?"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def cepstrum(
    signal: npt.ArrayLike, step: float, *, turn: float | None = None, floor: float = 1e-8
) -> dict[str, Array]:
    """Real power cepstrum of a signal with even steps of time [s]: the inverse Fourier transform of log |X|^2, of its
    Fourier transform X (Bogert, Healy & Tukey 1963; Randall, Mechanical Systems and Signal Processing 97, 2017).

    The result has the columns `quefrency` [s], up to half the duration, `turns` (quefrency in revolutions of `turn`
    seconds, if given) and `cepstrum` [1]. Sidebands at the distance 1/T give peaks at T, 2T, ...: if their amplitudes
    are those of 1/(1 - a exp(-i omega T)), peak n is a^n/n.

    The duration should be a whole number of revolutions, as the transform repeats the signal. The mean is left out.
    Powers below `floor` times the largest count as `floor`: computed signals have no noise, so that the logarithm of
    round-off between the lines would dominate. Compare signals with equal floors only.
    """
    if np.iscomplexobj(signal):
        raise ValueError("the signal must be real")
    for name, value in {"step": step, "turn": turn}.items():
        if value is not None and not 0 < value < np.inf:
            raise ValueError(f"`{name}` must be positive")
    values = np.asarray(signal, float)
    if values.ndim != 1 or values.size < 2 or not np.all(np.isfinite(values)):
        raise ValueError("the signal must be a list of at least two finite numbers")
    power = np.abs(np.fft.rfft(values - values.mean())) ** 2
    power[0] = power[1:].mean()
    if not power.max() > 0:
        raise ValueError("the signal is constant")
    found = np.fft.irfft(np.log(np.maximum(power, floor * power.max())), values.size)
    quefrency = step * np.arange(values.size // 2 + 1)
    turns = {} if turn is None else {"turns": quefrency / turn}
    return {"quefrency": quefrency, **turns, "cepstrum": found[: quefrency.size]}

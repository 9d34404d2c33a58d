"""The cepstrum of sidebands with a closed form, and of a drive with a cracked tooth."""

import numpy as np
import pytest

import gearatlas
from program import ROOT

TIERS = ROOT / "manifests/tiers"
TURN = 20  # mesh cycles


def test_peaks_of_geometric_sidebands_are_the_closed_form():
    """1/(1 - a exp(-i omega T)) is the transform of pulses a^n at nT; its log |.|^2 has the cepstrum a^n/n."""
    step, spacing, share = 1e-3, 128, 0.5
    signal = np.zeros(8192)
    signal[::spacing] = share ** np.arange(signal.size // spacing)
    # The pulse at 0 is not the mean of the signal: the mean moves one line only.
    found = gearatlas.cepstrum(signal, step, turn=spacing * step, floor=0.0)
    peaks = found["cepstrum"][spacing::spacing]
    order = np.arange(1, peaks.size + 1)
    np.testing.assert_allclose(found["turns"][spacing::spacing], order)
    # One line of 8192 has another value, the mean of the others.
    np.testing.assert_allclose(peaks, share**order / order, atol=5 / signal.size)
    others = np.delete(found["cepstrum"], np.arange(0, found["cepstrum"].size, spacing))
    assert np.abs(others).max() < 5 / signal.size


def cepstrum_of_drive(fault: str) -> np.ndarray:
    """Cepstrum over 16 turns of the torsional drive in steady contact, at multiples of the mesh period."""
    text = (TIERS / "torsional.toml").read_text().replace("friction = 0.05 ", "friction = 0 ")
    point = gearatlas.Manifest.from_text(text + fault, {}, TIERS).point(load=1.0, speed="3000 rpm")
    trace = gearatlas.trace(point, cycles=16 * TURN, skip=400, samples_per_cycle=64)
    assert len(trace.events["time"]) == 0
    velocity, time = trace.samples["velocity"][: 16 * TURN * 64], trace.samples["time"]
    step = time[1] - time[0]
    found = gearatlas.cepstrum(velocity, step, turn=64 * TURN * step, floor=1e-4)
    assert found["turns"][64 * TURN] == pytest.approx(1.0)
    return found["cepstrum"][::64]


def test_a_cracked_tooth_has_a_peak_at_a_turn():
    cracked = cepstrum_of_drive('\n[[mesh.tooth_fault]]\ngear = "pinion"\ntooth = 4\nstiffness = 0.7\n')
    sound = cepstrum_of_drive("")
    # The lines of the sound drive are a mesh order apart, so that all mesh periods are alike.
    assert sound[TURN] == pytest.approx(sound[TURN - 1], rel=1e-6)
    assert cracked[TURN] > 10 * abs(cracked[TURN - 1]) and cracked[TURN] > 3 * sound[TURN]
    assert cracked[2 * TURN] == pytest.approx(cracked[TURN], rel=1e-3)


def test_a_signal_without_a_spectrum_is_refused():
    for signal in ([1.0, 1.0, 1.0], [1.0], [1.0, float("nan")], [[1.0, 2.0]]):
        with pytest.raises(ValueError):
            gearatlas.cepstrum(signal, 1.0)
    for step, turn in [(0.0, 1.0), (-1.0, 1.0), (float("nan"), 1.0), (1.0, 0.0)]:
        with pytest.raises(ValueError, match="must be positive"):
            gearatlas.cepstrum([1.0, 2.0, 3.0], step, turn=turn)
    with pytest.raises(ValueError, match="real"):
        gearatlas.cepstrum([1.0, 2.0j], 1.0)

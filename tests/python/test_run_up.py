"""Spectra and order tracks of `atlas runup` beside those that SciPy computes of the signals."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import scipy.interpolate
import scipy.signal

ROOT = Path(__file__).resolve().parents[2]
WRITTEN = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "tmp"
FROM, TO, DURATION = 600 * 2 * np.pi / 60, 1500 * 2 * np.pi / 60, 2.0
TEETH, REVOLUTIONS = 20, 4


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("run-up") / "out"
    program = (WRITTEN / "exported" / "atlas").read_text()
    speed = 'runup.speed={ from = "600 rpm", to = "1500 rpm", in = "2 s" }'
    signals = 'runup.signals=["force", "bearings"]'
    manifest = ROOT / "manifests" / "run-up.toml"
    command = [program, "runup", manifest, "--set", speed, "--set", signals, "--out", out]
    subprocess.run(command, check=True, capture_output=True)
    return out


def decibels(found, exact):
    return 20 * np.log10(found / exact)


def test_spectrogram_is_that_of_scipy(folder):
    signals = pd.read_parquet(folder / "signals.parquet")
    spectra = pd.read_parquet(folder / "spectrogram.parquet")
    rate = round(1 / (signals.time[1] - signals.time[0]))
    for signal, column in [("force", "force"), ("bearing pinion 1 y", "bearing_pinion_1_y")]:
        own = spectra[spectra.signal == signal]
        length = round(rate / own.frequency_step.iloc[0])
        _, times, values = scipy.signal.stft(
            signals[column], rate, "hann", length, length // 2, detrend="constant", boundary=None, padded=False
        )
        assert np.allclose(times[: len(own)], own.time, atol=1 / rate)
        found = np.stack(own.amplitudes.to_list())
        exact = 2 * np.abs(values.T[: len(own), : found.shape[1]])
        starts = range(0, len(own) * (length // 2), length // 2)
        exact[:, 0] = [abs(signals[column][start : start + length].mean()) for start in starts]
        seen = exact > 1e-4 * exact.max()
        assert seen.sum() > 1000
        assert np.abs(decibels(found[seen], exact[seen])).max() < 0.1


def test_order_tracks_are_those_of_resampled_signals(folder):
    signals = pd.read_parquet(folder / "signals.parquet")
    tracks = pd.read_parquet(folder / "order_tracks.parquet")
    rate = (TO - FROM) / DURATION
    angle = FROM * signals.time + 0.5 * rate * signals.time**2
    resampled = scipy.interpolate.CubicSpline(angle, signals.bearing_pinion_1_y)
    own = tracks[tracks.signal == "bearing pinion 1 y"]
    worst, compared = 0.0, 0
    for order in [20.0, 40.0, 60.0]:
        track = own[own.order == order].reset_index()
        for _, row in track.iterrows():
            # Time is the mean of both ends of a stretch; its angle follows from its length.
            time = row.time
            width = 2 * np.pi * REVOLUTIONS
            ends = solve_ends(time, width, rate)
            theta = np.linspace(ends[0], ends[1], 20001)[:-1]
            window = 1 - np.cos(2 * np.pi * (theta - ends[0]) / width)
            value = 2 * np.mean(window * resampled(theta) * np.exp(-1j * order * theta))
            if abs(value) > 0.05 * track.amplitude.max():
                worst = max(worst, abs(decibels(row.amplitude, abs(value))))
                compared += 1
    assert compared > 20
    assert worst < 0.1


def solve_ends(time, width, rate):
    """Angles where a stretch of some width begins and ends whose ends have this mean time."""
    passed = lambda t: FROM * t + 0.5 * rate * t**2
    when = lambda a: (-FROM + np.sqrt(FROM**2 + 2 * rate * a)) / rate
    low, high = 0.0, passed(time)
    for _ in range(80):
        start = 0.5 * (low + high)
        middle = 0.5 * (when(start) + when(start + width))
        low, high = (start, high) if middle < time else (low, start)
    return start, start + width


def test_both_branches_of_a_jump_are_those_of_fixed_speeds(tmp_path):
    """Between two jumps a drive rattles strongly on the way up, and stays in contact on the way down."""
    program = (WRITTEN / "exported" / "atlas").read_text()
    text = (ROOT / "manifests" / "tiers" / "torsional.toml").read_text()
    drive = ["grid.load=0.3", 'mesh.half_gap="75 um"', "mesh.friction=0"]

    def call(command, *settings):
        line = [program, command, tmp_path / "m.toml", "--out", tmp_path / command, "--overwrite"]
        for setting in [*drive, *settings]:
            line += ["--set", setting]
        subprocess.run(line, check=True, capture_output=True)

    section = "[runup]\nspeed = { from = 10, to = 20, in = 1 }\nsample_rate = 1000\nrevolutions = 2\n"
    (tmp_path / "m.toml").write_text(f'{text}\n{section}signals = ["deflection"]\n')
    sweep = ['grid.order="both"', "run.transient=300", "run.cycles=200", "analyses={nvh={}}"]
    call("run", "grid.speed={from=1000,to=2400,count=29}", *sweep)
    points = pd.read_parquet(tmp_path / "run" / "points.parquet")
    at = points[points.speed == 1700].set_index("direction").deflection_rms
    assert at["up"] > 30 * at["down"]

    def passes(first, last, duration):
        call("runup", f"runup.speed={{from={first},to={last},in={duration}}}")
        levels = pd.read_parquet(tmp_path / "runup" / "levels.parquet").sort_values("speed")
        return np.interp(1700, levels.speed, levels.rms)

    # In contact it lags in proportion to the rate. Rattle rings, so that it comes near without an order.
    lags = [at["down"] - passes(2400, 1500, duration) for duration in (4, 8)]
    assert abs(np.log2(lags[0] / lags[1]) - 1) < 0.05 and 0 < lags[1] < 3e-3 * at["down"]
    assert abs(passes(800, 1900, 4) / at["up"] - 1) < 3e-3

"""Escape from chaotic saddles: an open baker's map in closed form, and a mass that leaves a well, in three ways."""

import numpy as np
import pytest

import gearatlas
from program import ROOT

# Two strips of the unit square are stretched by A and B and contracted by C; what lies between them escapes.
A, B, C = 2.2, 4.0, 0.3
RATE = -np.log(1 / A + 1 / B)
SHARES = np.array([1 / A, 1 / B]) / (1 / A + 1 / B)
EXPONENT = SHARES @ np.log([A, B])
ENTROPY = -SHARES @ np.log(SHARES)


def baker(states):
    x, y = states.T
    left, right = x < 1 / A, x > 1 - 1 / B
    return np.stack([np.where(left, A * x, np.where(right, B * (x - 1) + 1, 7.0)), np.where(left, C * y, 1 - C + C * y)], axis=1)


def baker_slope(states):
    slope = np.zeros((len(states), 2, 2))
    slope[:, 0, 0], slope[:, 1, 1] = np.where(states[:, 0] < 1 / A, A, B), C
    return slope


def in_square(states):
    return (states[:, 0] >= 0.0) & (states[:, 0] <= 1.0)


@pytest.fixture(scope="module")
def starts() -> np.ndarray:
    return np.random.default_rng(3).random((100000, 2))


@pytest.fixture(scope="module")
def saddle(starts) -> gearatlas.ChaoticSaddle:
    return gearatlas.chaotic_saddle(baker, in_square, starts, life=20)


def test_survivors_of_a_baker_s_map_fall_at_its_rate(starts):
    assert np.isclose(RATE, EXPONENT - ENTROPY)
    found = gearatlas.escape(baker, in_square, starts, after=3, most=30)
    assert found.stderr < 0.003 and abs(found.rate - RATE) < 3.0 * found.stderr
    cut_short = gearatlas.escape(baker, in_square, starts, after=3, most=6)
    assert cut_short.stderr < 0.004 and abs(cut_short.rate - RATE) < 3.0 * cut_short.stderr
    assert found.survivors[0] == len(starts)
    assert np.allclose(found.survivors[1:5] / len(starts), np.exp(-RATE * np.arange(1, 5)), rtol=0.02)


def test_walkers_stay_on_the_cantor_set_and_sample_its_natural_measure(saddle):
    states = saddle.states
    assert states.shape == (64, 400, 2) and 0.0 < saddle.largest < 1e-4
    following = baker(states[:, :-1].reshape(-1, 2)).reshape(64, 399, 2)
    # A step moves by a displacement of a few parts in 1e5 at most, and every state survives the next 20.
    assert np.abs(following - states[:, 1:]).max() < 2e-5
    assert in_square(states.reshape(-1, 2)).all()
    shares = [(states[:, :, 0] < 1 / A).mean(axis=1), (states[:, :, 0] > 1 - 1 / B).mean(axis=1)]
    for share, exact in zip(shares, SHARES):
        assert abs(share.mean() - exact) < 4.0 * share.std(ddof=1) / 8.0
    exponents, stderr = saddle.exponents(baker_slope)
    assert stderr[0] < 0.003 and abs(exponents[0] - EXPONENT) < 4.0 * stderr[0]
    assert np.isclose(exponents[1], np.log(C))


def test_dimension_and_rate_of_the_saddle(saddle):
    exact = ENTROPY / EXPONENT + ENTROPY / -np.log(C)
    dimension, stderr = saddle.dimension()
    assert stderr < 0.05 and abs(dimension - exact) < 0.015 * exact
    rate, stderr = saddle.escape_rate(baker_slope)
    assert stderr < 0.03 and abs(rate - RATE) < 0.01


def test_a_map_of_one_dimension(starts):
    def tent(states):
        return 3.0 * np.minimum(states, 1.0 - states)

    saddle = gearatlas.chaotic_saddle(tent, in_square, starts[:, :1], life=22, length=200)
    exponents, _ = saddle.exponents(lambda states: np.where(states < 0.5, 3.0, -3.0)[:, :, np.newaxis])
    assert np.allclose(exponents, np.log(3.0))
    assert abs(saddle.dimension()[0] - np.log(2.0) / np.log(3.0)) < 0.02


def test_a_mass_leaves_a_well_at_one_rate_in_three_ways():
    mapped = gearatlas.CycleMap(gearatlas.load(ROOT / "manifests/oscillators/escape.toml").point())
    random = np.random.default_rng(1)
    starts = random.uniform([-1.0, -2.0], [2.0, 2.0], size=(200000, 2))

    def in_well(states):
        return states[:, 0] > -3.0

    found = gearatlas.escape(mapped, in_well, starts, after=12, most=60)
    assert found.stderr < 0.01 * found.rate
    saddle = gearatlas.chaotic_saddle(mapped, in_well, starts, life=30, length=120)
    # Starts near the saddle have no transient of their own but the time to leave it.
    near = saddle.states.reshape(-1, 2)
    again = gearatlas.escape(mapped, in_well, near + 1e-3 * random.normal(size=near.shape), after=20, most=60)
    assert abs(again.rate - found.rate) < 3.0 * np.hypot(again.stderr, found.stderr)

    def slope(states):
        return mapped.image(states, jacobian=True).jacobian

    # The damping of 0.3 /s contracts areas over the period of the shaker.
    exponents, _ = saddle.exponents(slope)
    assert np.isclose(exponents.sum(), -0.3 * mapped.period)
    rate, stderr = saddle.escape_rate(slope)
    assert stderr < 0.04 and abs(rate - found.rate) < 3.0 * stderr


def test_errors_say_what_to_change(starts):
    with pytest.raises(gearatlas.AtlasError, match="no start stays in the region for 60"):
        gearatlas.chaotic_saddle(baker, in_square, starts, life=60)
    with pytest.raises(gearatlas.AtlasError, match="no start leaves the region"):
        gearatlas.escape(lambda states: states, in_square, starts, after=3, most=10)

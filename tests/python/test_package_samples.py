"""Statistics over samples: intervals that cover as often as they say, Sobol' indices of a function with known ones."""

import math

import numpy as np
import pytest

import gearatlas
from program import ROOT

TOLERANCES = ROOT / "manifests/tolerances.toml"
OSCILLATOR = (ROOT / "tests/data/oscillator.toml").read_text()

ENDS = {
    "mesh.half_gap": [10e-6, 20e-6],
    "mesh.mean_stiffness": [3e8, 5e8],
    "excitation.transmission_error.0.amplitude": [1e-6, 9e-6],
}
KEYS = list(ENDS)


def grid(samples: int, design: str = "sobol", seed: int = 0):
    """The samples of three uniform axes, without a run."""
    head, rest = OSCILLATOR.split("[grid]")
    axes = "\n".join(f'"{key}" = {{ uniform = {ends} }}' for key, ends in ENDS.items())
    text = f"{head}[grid]\nsamples = {samples}\ndesign = \"{design}\"\nload = 0.1\nspeed = 700.0\n{axes}\n\n{rest[rest.index('[run]'):]}"
    return gearatlas.Manifest.from_text(text, {"job.seed": seed}, ROOT / "tests/data").grid


def angles(table):
    """The three axes of `grid`, uniform from -pi to pi."""
    return [2 * math.pi * ((table[key] - low) / (high - low) - 0.5) for key, (low, high) in ENDS.items()]


def test_indices_of_the_function_of_ishigami_are_the_closed_form():
    """Ishigami & Homma, 1990: f = sin x + a sin² y + b z⁴ sin x has the variance a²/8 + bπ⁴/5 + b²π⁸/18 + 1/2."""
    a, b = 7.0, 0.1

    def function(table):
        x, y, z = angles(table)
        return np.sin(x) + a * np.sin(y) ** 2 + b * z**4 * np.sin(x)

    found = gearatlas.sobol_indices(grid(4096, "saltelli"), function)
    of_x, of_y = 0.5 * (1 + b * math.pi**4 / 5) ** 2, a**2 / 8
    of_xz = b**2 * math.pi**8 * 8 / 225
    variance = of_x + of_y + of_xz
    # In the order of the axes, which is that of their names.
    order = ["excitation.transmission_error.0.amplitude", "mesh.half_gap", "mesh.mean_stiffness"]
    assert found["axis"].tolist() == order
    first = dict(zip(KEYS, [of_x / variance, of_y / variance, 0.0]))
    total = dict(zip(KEYS, [(of_x + of_xz) / variance, of_y / variance, of_xz / variance]))
    np.testing.assert_allclose(found["first"], [first[key] for key in order], atol=0.02)
    np.testing.assert_allclose(found["total"], [total[key] for key in order], atol=0.02)
    assert np.all(np.abs(found["first"] - [first[key] for key in order]) <= 2 * found["first_error"])
    assert np.all(found["samples"] == 4096) and np.all(found["missing"] == 0)


def test_samples_without_a_value_are_left_out():
    table = grid(64, "saltelli")

    def function(table):
        values = angles(table)[0].copy()
        values[7] = np.nan
        return values

    found = gearatlas.sobol_indices(table, function)
    assert np.all(found["samples"] == 63) and np.all(found["missing"] == 1)
    with pytest.raises(ValueError, match="does not vary"):
        gearatlas.sobol_indices(table, lambda table: np.ones(table.rows))
    with pytest.raises(ValueError, match="saltelli"):
        gearatlas.sobol_indices(grid(8), function)
    with pytest.raises(ValueError, match="no samples"):
        gearatlas.quantiles(gearatlas.load(ROOT / "manifests/quickstart.toml").grid, "load")
    with pytest.raises(ValueError, match="no grid"):
        table.on_grid("mesh.half_gap")


@pytest.mark.parametrize("share", [0.02, 0.3, 0.5])
def test_intervals_cover_as_often_as_they_say(share):
    """Over 400 scrambles: the share of a half space of all three axes, and its limit. The true values come from a million
    independent samples, whose error is a tenth of the intervals."""
    rng = np.random.default_rng(3)
    weights = np.array([1.0, -0.7, 0.4])
    brute = np.sort(np.sin(rng.uniform(-math.pi, math.pi, (1_000_000, 3)) @ weights))
    limit = np.quantile(brute, share)

    def value(table):
        return np.sin(np.stack(angles(table), axis=1) @ weights)

    covered = {"quantile": 0, "probability": 0}
    seeds = 400
    for seed in range(seeds):
        table = grid(100, seed=seed)
        row = gearatlas.quantiles(table, value, share)
        covered["quantile"] += bool(row["low"][0] <= limit <= row["high"][0])
        row = gearatlas.probability(table, lambda table: value(table) < limit)
        covered["probability"] += bool(row["low"][0] <= share <= row["high"][0])
    # Binomial: 95 % of 400 less three standard deviations is 367.
    assert min(covered.values()) >= 367, covered


def test_the_interval_of_a_quantile_is_between_samples():
    """Of 100 independent samples the interval of the median with at least 95 % is from the 40th to the 61st: Conover,
    Practical Nonparametric Statistics, 1999, section 3.2."""
    table = grid(100)
    row = gearatlas.quantiles(table, "mesh.half_gap", [0.5, 0.001])
    values = np.sort(table["mesh.half_gap"])
    assert (row["low"][0], row["high"][0]) == (values[39], values[60])
    assert row["value"][0] == np.median(values)
    assert row["low"][1] == -np.inf and row["samples"].tolist() == [100, 100]


def test_the_interval_of_no_event_has_no_width_below():
    """Clopper & Pearson of 0 in n: 1 - 0.025^(1/n). A point that is unknown may be an event."""
    table = grid(50)
    none = gearatlas.probability(table, lambda table: np.zeros(table.rows))
    assert none["low"][0] == none["probability"][0] == 0
    assert none["high"][0] == pytest.approx(1 - 0.025 ** (1 / 50))
    unknown = gearatlas.probability(table, lambda table: np.where(np.arange(table.rows) == 3, np.nan, 0.0))
    assert unknown["unknown"][0] == 1 and unknown["high"][0] > none["high"][0]
    every = gearatlas.probability(table, lambda table: np.ones(table.rows, bool))
    assert (every["probability"][0], every["high"][0]) == (1, 1)
    assert every["low"][0] == pytest.approx(0.025 ** (1 / 50))


def test_results_have_a_row_per_speed(tmp_path):
    results = gearatlas.run(TOLERANCES, tmp_path / "out", set={"grid.samples": 16, "run.cycles": 300}, progress=False)
    found = gearatlas.quantiles(results, "force_peak", [0.25, 0.75])
    assert found["q"].tolist() == [0.25, 0.75] * 2
    assert found["speed"].tolist() == sorted(found["speed"].tolist())
    assert np.all(found["low"] <= found["value"]) and np.all(found["value"] <= found["high"])
    rattle = gearatlas.probability(results, by="speed")
    assert np.all((rattle["low"] <= rattle["probability"]) & (rattle["probability"] <= rattle["high"]))
    with pytest.raises(ValueError, match="also differ in speed"):
        gearatlas.probability(results, by=[])
    with pytest.raises(ValueError, match="no column `no such column`"):
        gearatlas.quantiles(results, "no such column")
    with pytest.raises(ValueError, match="no column `nonsense`"):
        gearatlas.probability(results, by=["speed", "nonsense"])
    with pytest.raises(ValueError, match="truth values"):
        gearatlas.probability(results, "force_peak", by="speed")

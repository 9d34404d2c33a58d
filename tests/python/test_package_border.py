"""Borders of basins: against a map with a known border, orbits of `follow`, the stable manifold, and neighbours on either side."""

import subprocess
import sys

import numpy as np
import pytest

import gearatlas
from program import ROOT

MANIFEST = ROOT / "manifests/oscillators/one-sided-stop.toml"
GRID = {"speed": 2.8, "contact.stop.gap": {"from": 0.1, "to": 0.2, "count": 5}, "contact.stop.stiffness": 30.0}
CONTINUATION = {"over": "contact.stop.gap", "starts": 6, "longest_period": 2}


class Valleys:
    """x → 1.5 x − x³/2, y → y/2 + x/5 in turned axes: motions at x = ±1, a border at x = 0 and the saddle 0 on it."""

    base_period, weighted_components, weights = 1, np.arange(2), np.ones(2)
    turned = np.array([[0.6, 0.8], [-0.8, 0.6]])

    def image(self, states, cycles: int = 1, *, jacobian: bool = False):
        states = np.array(np.atleast_2d(states), dtype=float)
        slope = np.tile(np.eye(2), (len(states), 1, 1))
        for _ in range(cycles):
            x, y = (states @ self.turned.T).T
            states = np.stack([1.5 * x - 0.5 * x**3, 0.5 * y + 0.2 * x], axis=1) @ self.turned
            own = np.zeros_like(slope)
            own[:, 0, 0], own[:, 1, 0], own[:, 1, 1] = 1.5 - 1.5 * x**2, 0.2, 0.5
            slope = self.turned.T @ own @ self.turned @ slope
        return gearatlas.Image(states, slope, None, {}, None, {})

    def __call__(self, states, cycles: int = 1):
        return self.image(states, cycles).states.reshape(np.shape(states))


def test_a_border_in_closed_form():
    valleys = Valleys()
    found = gearatlas.border(valleys, [0.9, 1.1], [-1.2, 0.3], cycles=120)
    assert abs((valleys.turned @ found.state)[0]) < 2e-12 and found.width < 3e-12
    assert found.period == 1 and np.abs(found.saddle).max() < 1e-14
    assert np.allclose(found.multipliers, [1.5, 0.5])
    # The motion along the border halves its distance in every step.
    assert np.allclose((valleys.turned @ found.track.T)[1, 1:9] / (valleys.turned @ found.track.T)[1, :8], 0.5)


@pytest.fixture(scope="module")
def oscillator(tmp_path_factory):
    """A saddle that `follow` finds, and the map where it is."""
    manifest = gearatlas.load(MANIFEST, set={"grid": GRID, "continuation": CONTINUATION})
    branches = gearatlas.follow(manifest, tmp_path_factory.mktemp("out") / "case").branches
    rows = [row for row in branches if row["unstable"] == 1 and row["multiplier_re"] > 1.2]
    row = min(rows, key=lambda row: abs(row["contact.stop.gap"] - 0.195))
    mapped = gearatlas.CycleMap(manifest.point(0)).at({"contact.stop.gap": row["contact.stop.gap"]})
    return mapped, mapped.from_modal(row["displacement"], row["modal_velocity"]), row


def test_the_saddle_is_the_orbit_that_branches_have(oscillator):
    mapped, state, row = oscillator
    found = gearatlas.border(mapped, [0.0, 0.0], [0.0, -0.9])
    assert found.period == row["period"] == 2
    assert min(np.abs(found.saddle - mapped(state, cycle)).max() for cycle in range(2)) < 1e-9
    assert abs(found.multipliers[0] - row["multiplier_re"]) < 1e-6
    assert np.linalg.norm(found.track[-1] - found.saddle) < 1e-5


def test_the_border_is_the_stable_manifold_and_parts_neighbours(oscillator):
    mapped = oscillator[0]
    found = gearatlas.border(mapped, [0.0, 0.0], [0.0, -0.9])
    ends = [mapped(found.state + sign * np.array([0.0, 1e-9]), 1000) for sign in (1.0, -1.0)]
    assert min(np.linalg.norm(mapped(ends[0], cycle) - ends[1]) for cycle in range(12)) > 0.01
    curves = gearatlas.manifold(mapped, found.saddle, 2, stable=True, length=3.0, step=0.02)
    assert min(np.linalg.norm(branch - found.state, axis=1).min() for branch in curves) < 0.01


def test_the_saddle_of_a_drive_of_two_modes_is_an_orbit_that_branches_have(tmp_path):
    speeds = {"from": 200, "to": 340, "count": 8}
    continuation = {"over": "speed", "starts": 6, "longest_period": 1}
    manifest = gearatlas.load(ROOT / "manifests/basins.toml", set={"grid.speed": speeds, "continuation": continuation})
    branches = gearatlas.follow(manifest, tmp_path / "case").branches
    row = min((row for row in branches if row["unstable"] == 1), key=lambda row: abs(row["speed"] - 265.0))
    mapped = gearatlas.CycleMap(manifest.point(0)).at(speed=row["speed"])
    weak, strong = mapped.start() - np.array([5e-6, 0, 0, 0]), mapped.start() + np.array([60e-6, 0, 0, 0])
    found = gearatlas.border(mapped, weak, strong)
    orbit = mapped.from_modal(row["displacement"], row["modal_velocity"])
    assert found.period == 1 and np.linalg.norm(mapped.weights * (found.saddle - orbit)) < 1e-9
    assert abs(found.multipliers[0] - row["multiplier_re"]) < 1e-9


def test_starts_in_one_basin_have_no_border(oscillator):
    with pytest.raises(gearatlas.AtlasError, match="both starts lead to the same motion"):
        gearatlas.border(oscillator[0], [0.0, 0.0], [0.0, 0.1])


def test_the_example_finds_the_saddle_of_a_drive_of_two_modes():
    told = subprocess.run([sys.executable, ROOT / "examples/border.py"], check=True, capture_output=True, text=True).stdout
    assert "a saddle of period 1 with one multiplier outside the unit circle" in told

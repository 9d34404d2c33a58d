"""Invariant circles: against circles known in closed form, long motions, an independent integrator, and locked orbits."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearatlas
from program import ROOT

MANIFEST = ROOT / "manifests/oscillators/flutter.toml"
AMPLITUDE = "harmonic_load.shaker.amplitude"
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


class Turning:
    """(r, φ, z) → (r + s (R − r), φ + ρ(p) + 0.1 (r − R), z/2 + ...) in bent coordinates; the circle r = R = 1 + p is kept."""

    base_period, weighted_components, weights = 1, np.arange(3), np.array([1.0, 2.0, 0.5])

    def __init__(self, p: float = 0.0, pull: float = 0.4) -> None:
        self.p, self.pull, self.point = p, pull, {"p": p}

    def at(self, values) -> "Turning":
        return Turning(values["p"], self.pull)

    @staticmethod
    def bent(flat):
        x, y, z = flat.T
        return np.stack([x, y + 0.2 * x**2, z + 0.3 * x * y], axis=1)

    def circle(self, turns):
        angle = 2.0 * np.pi * np.asarray(turns)
        radius = 1.0 + self.p
        return self.bent(np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.0 * angle], axis=1))

    def __call__(self, states, cycles: int = 1):
        states = np.asarray(states, dtype=float)
        x, y, z = np.atleast_2d(states).T
        y, z = y - 0.2 * x**2, z - 0.3 * x * (y - 0.2 * x**2)
        for _ in range(cycles):
            radius, angle = np.hypot(x, y), np.arctan2(y, x)
            off = radius - 1.0 - self.p
            angle += 2.0 * np.pi * (GOLDEN + self.p + 0.1 * off)
            radius, z = radius - self.pull * off, 0.5 * z
            x, y = radius * np.cos(angle), radius * np.sin(angle)
        return self.bent(np.stack([x, y, z], axis=1)).reshape(states.shape)

    def image(self, states, cycles: int = 1, *, jacobian: bool = False, by=()):
        step = 1e-6
        slope = [(self(states + step * e, cycles) - self(states - step * e, cycles)) / (2 * step) for e in np.eye(3)]
        by_p = (self.at({"p": self.p + step})(states, cycles) - self.at({"p": self.p - step})(states, cycles)) / (2 * step)
        return gearatlas.Image(self(states, cycles), np.stack(slope, axis=2), None, {"p": by_p}, None, {})


def test_a_circle_in_closed_form_is_found_to_round_off():
    mapped = Turning()
    found = gearatlas.torus(mapped, [0.5, 0.1, 0.3], tolerance=1e-9)
    assert min(abs(found.rotation - GOLDEN), abs(found.rotation - (1.0 - GOLDEN))) < 1e-12
    assert found.residual < 1e-10 and found.error < 1e-9
    assert found.distance(mapped.circle(np.linspace(0.0, 1.0, 50))).max() < 1e-8


def test_a_circle_that_repels_is_found_from_a_neighbour():
    start = gearatlas.torus(Turning(), [0.5, 0.1, 0.3])
    repelling = Turning(0.05, pull=-0.5)
    found = gearatlas.torus(repelling, start)
    assert found.distance(repelling.circle(np.linspace(0.0, 1.0, 50))).max() < 1e-8
    assert not np.isclose(np.linalg.norm(repelling(found.circle(0.2) * 1.01, 40)), np.linalg.norm(found.circle(0.2)), rtol=0.1)


def test_a_free_key_gets_the_value_of_a_rotation_number():
    start = gearatlas.torus(Turning(), [0.5, 0.1, 0.3])
    sign = 1.0 if abs(start.rotation - GOLDEN) < 1e-6 else -1.0
    found = gearatlas.torus(Turning(), start, rotation=start.rotation + sign * 0.03, free="p")
    assert abs(found.map.p - 0.03) < 1e-10 and found.rotation_error == 0.0
    assert found.distance(found.map.circle(np.linspace(0.0, 1.0, 50))).max() < 1e-8


@pytest.fixture(scope="module")
def mapped() -> gearatlas.CycleMap:
    return gearatlas.CycleMap(gearatlas.load(MANIFEST).point())


@pytest.fixture(scope="module")
def circle(mapped) -> gearatlas.Torus:
    return gearatlas.torus(mapped, mapped.start(), tolerance=1e-3)


def test_a_long_motion_lies_on_the_circle_and_turns_at_its_rate(mapped, circle):
    assert circle.error < 1e-3
    state, states = mapped(mapped.start(), 5000), []
    for _ in range(20000):
        states.append(state := mapped(state))
    orbit = np.array(states)
    assert circle.distance(orbit[::40]).max() < circle.error
    centre = circle.circle.nodes.mean(axis=0)
    turns = np.unwrap(np.arctan2(*(orbit - centre)[:, [3, 1]].T)) / (2.0 * np.pi)
    # The plain average has an error of one turn over its length.
    rate = (turns[-1] - turns[0]) / (len(turns) - 1) % 1.0
    assert min(abs(rate - circle.rotation), abs(1.0 - rate - circle.rotation)) < 1.0 / len(turns)


def test_the_error_falls_with_the_square_of_the_nodes(mapped):
    few, many = (gearatlas.torus(mapped, mapped.start(), most=most) for most in (70, 280))
    assert len(many.circle) == 271 and len(few.circle) == 67
    assert many.residual < few.residual / 4.0 and many.residual < many.error


def test_without_a_shaker_it_turns_at_the_frequency_of_the_self_excited_motion(mapped):
    still = mapped.at({AMPLITUDE: 1e-9})
    found = gearatlas.torus(still, still.start(), tolerance=1e-3)

    def rate(_, state):
        x, y, u, v = state
        stop = 3.0 * (max(y - 1.0, 0.0) + min(y + 1.0, 0.0))
        return [u, v, -0.072 * u - 0.81 * x + 0.25 * y, -0.08 * v - y - 0.25 * x - stop]

    up = lambda _, state: state[1]  # noqa: E731
    up.direction = 1.0
    met = solve_ivp(rate, (0.0, 600.0), [0.5, 0.1, 0.0, 0.0], events=up, rtol=1e-10, atol=1e-12, max_step=0.05).t_events[0]
    turns = still.period / (met[-1] - met[-11]) * 10.0
    assert abs(turns - found.rotation) < 1e-6


@pytest.fixture(scope="module")
def folds(tmp_path_factory) -> list[float]:
    found = gearatlas.follow(MANIFEST, tmp_path_factory.mktemp("out") / "case").bifurcations
    return sorted(row["speed"] for row in found if row["kind"] == "fold" and row["period"] == 3)


def test_circles_end_where_the_motion_locks(circle, folds):
    followed = gearatlas.tori(circle, "speed", 3.05, tolerance=5e-3, most=135)
    speeds = np.array([own.map.point["speed"] for own in followed])
    rotations = np.array([own.rotation for own in followed])
    assert (np.diff(rotations) < 0.0).all() and 1 / 3 < rotations[-1] < 0.337
    assert folds[0] - 0.015 < speeds[-1] < folds[0]
    # The distance from 1/3 is the square root of the distance from the fold, to first order.
    line = np.polyfit((rotations[-5:] - 1 / 3) ** 2, speeds[-5:], 2)
    assert abs(line[-1] - folds[0]) < 1e-3


def test_a_curve_of_a_rotation_number_runs_beside_the_tongue(circle, folds):
    followed = gearatlas.tori(circle, AMPLITUDE, 0.3, free="speed", step=0.05, tolerance=5e-3, most=135)
    assert followed[-1].map.point[AMPLITUDE] == 0.3
    assert {own.rotation for own in followed} == {circle.rotation}
    last = followed[-1]
    assert last.map.point["speed"] < folds[0]
    again = gearatlas.torus(last.map, last.map.start(), tolerance=5e-3, most=135)
    assert abs(again.rotation - last.rotation) < 1e-5


def test_a_motion_that_repeats_has_no_circle(mapped, folds):
    locked = mapped.at(speed=0.5 * (folds[0] + folds[1]))
    with pytest.raises(gearatlas.AtlasError, match="no circle"):
        gearatlas.torus(locked, locked.start())


def test_the_example_follows_the_tongue():
    command = [sys.executable, ROOT / "examples/tongue.py"]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert "locked at 1/3 from 3.0252 to 3.0830 rad/s" in told

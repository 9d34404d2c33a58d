"""examples/cycle_expansion.py: its orbits on a drive with one degree of freedom, and its series on a map whose are known."""

import importlib.util
import itertools
from pathlib import Path

import numpy as np

import gearatlas

EXAMPLE = Path(__file__).resolve().parents[2] / "examples/cycle_expansion.py"
spec = importlib.util.spec_from_file_location("cycle_expansion", EXAMPLE)
example = importlib.util.module_from_spec(spec)
spec.loader.exec_module(example)


def test_orbits_of_a_thin_set_are_all_found_and_average_to_what_a_run_does(tmp_path):
    keys = {f"grid.{axis}": value for axis, value in example.POINT.items()}
    manifest = gearatlas.load(example.MANIFEST, keys)
    cycle = gearatlas.CycleMap(manifest.point(0))
    found = example.orbits(cycle, 5)
    assert [sum(orbit.period == n for orbit in found) for n in range(1, 6)] == [1, 5, 4, 3, 14]
    for orbit in found:
        turned = np.roll(orbit.points, -1, axis=0)
        assert np.linalg.norm(cycle.weights * (cycle(orbit.points) - turned), axis=1).max() < 1e-6
        # Prime: no two of its points are one, and one multiplier lies beyond the unit circle.
        apart = np.linalg.norm(cycle.weights * (orbit.points[:, np.newaxis] - orbit.points), axis=2)
        assert orbit.period == 1 or apart[~np.eye(orbit.period, dtype=bool)].min() > 1e-6
        assert abs(orbit.multipliers[0]) > 1 and np.prod(np.abs(orbit.multipliers)) < 1

    averages, missing = example.expand(found, 5)
    run = gearatlas.run(manifest, tmp_path / "run", progress=False).points
    error = abs(averages[4] - averages[3])
    assert abs(averages[4] - run["lambda_max"][0]) < error < 0.1
    assert abs(missing[4]) < 0.2 < abs(missing[0])


def test_the_series_of_a_tent_map_is_exact_and_without_an_orbit_it_is_not():
    slopes = {"0": 3.0, "1": -1.5}  # 1/3 + 1/1.5 = 1: all of the interval is mapped onto it twice
    exact = sum(np.log(abs(slope)) / abs(slope) for slope in slopes.values())
    found = []
    for n in range(1, 7):
        for word in map("".join, itertools.product("01", repeat=n)):
            turns = [word[i:] + word[:i] for i in range(n)]
            if word == min(turns) and turns.count(word) == 1:
                multiplier = np.prod([slopes[symbol] for symbol in word])
                found.append(example.Orbit(np.zeros((n, 2)), np.array([multiplier, 0.0])))
    assert [sum(orbit.period == n for orbit in found) for n in range(1, 7)] == [2, 1, 2, 3, 6, 9]
    averages, missing = example.expand(found, 6)
    np.testing.assert_allclose(averages, exact, rtol=1e-12)
    np.testing.assert_allclose(missing, 0.0, atol=1e-12)
    averages, missing = example.expand(found[:2] + found[3:], 6)
    assert abs(averages[-1] - exact) > 0.005 and abs(missing[-1]) > 0.005

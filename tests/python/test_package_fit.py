"""Fits of keys to measured points: known truths, known derivatives, and what is refused."""

import warnings

import numpy as np
import pint
import pytest

import gearatlas
from gearatlas._fit import _Problem, _sigma
from gearatlas._measured import measured_points
from program import ROOT

MODAL = ROOT / "tests/data/oscillator.modal.toml"
# The oscillator strikes both flanks, so that damping and half gap both matter.
TRUTH = {"mesh.contact_damping": 0.2, "mesh.half_gap": 15e-6}
START = {"mesh.contact_damping": 0.18, "mesh.half_gap": 14e-6}
KEYS = list(TRUTH)
SLOWEST, FASTEST = 360.0, 660.0
SPEEDS = np.linspace(SLOWEST, FASTEST, 8)


def manifest(**changes: object) -> dict[str, object]:
    grid = {"load": {"values": [0.3]}, "speed": {"from": SLOWEST, "to": FASTEST, "count": 5}}
    return {
        "job": {"name": "fitted"},
        "model": {"kind": "modal", "file": str(MODAL)},
        "mesh": {
            "half_gap": START["mesh.half_gap"], "stiffness": "piecewise", "mean_stiffness": 4e8, "contact_ratio": 1.6,
            "single_pair_drop": 0.25, "contact_damping": START["mesh.contact_damping"],
        },
        "excitation": {"transmission_error": [{"harmonic": 1, "amplitude": 15e-6}]},
        "grid": grid,
        "run": {"transient": 50, "cycles": 300},
        "analyses": {"nvh": {"harmonics": 3}, "lyapunov": {"effort": "survey"}},
        **changes,
    }


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    return tmp_path_factory.mktemp("tables")


@pytest.fixture(scope="module")
def curve(tables) -> np.ndarray:
    changes = {**TRUTH, "grid.speed": {"values": SPEEDS.tolist()}}
    points = gearatlas.run(manifest(), set=changes, progress=False, tables=tables).points
    assert set(points["class"]) <= {"periodic", "steady_contact"}
    return points["deflection_rms"]


def noisy(curve: np.ndarray, part: float, seed: int) -> dict[str, np.ndarray]:
    error = np.full(len(curve), part * curve.mean())
    noise = error * np.random.default_rng(seed).normal(size=len(curve))
    return {"speed": SPEEDS, "deflection_rms": curve + noise, "stderr": error}


def test_exact_points_give_back_the_keys(curve, tables):
    fit = gearatlas.fit(manifest(), {"speed": SPEEDS, "deflection_rms": curve}, KEYS, tables=tables)
    np.testing.assert_allclose(fit.values, list(TRUTH.values()), rtol=1e-6)
    np.testing.assert_allclose(fit.computed, curve, rtol=1e-7)
    assert fit.units == ["1", "m"] and not fit.known_errors and fit.freedoms == len(SPEEDS) - 2


def test_the_region_holds_the_truth_as_often_as_it_says(curve, tables):
    held = 0
    for seed in range(20):
        fit = gearatlas.fit(manifest(), noisy(curve, 0.02, seed), KEYS, tables=tables)
        held += fit.inside(TRUTH)
        assert fit.distance(dict(zip(KEYS, fit.values))) == 0
    # Fewer than 17 of 20 have a probability of 1.6 % if each holds it with 95 %.
    assert held >= 17, held


def test_estimated_errors_are_those_of_the_noise(curve, tables):
    points = noisy(curve, 0.02, 1)
    known = gearatlas.fit(manifest(), points, KEYS, tables=tables)
    del points["stderr"]
    fit = gearatlas.fit(manifest(), points, KEYS, tables=tables)
    np.testing.assert_allclose(fit.values, known.values, rtol=1e-5)
    # The estimate of the variance is that of the residuals: χ² of the known fit over its freedoms.
    ratio = known.chi_squared / known.freedoms
    np.testing.assert_allclose(fit.covariance, ratio * known.covariance, rtol=1e-3)
    assert fit.chi_squared == pytest.approx(fit.freedoms)
    low, high = fit.intervals().T
    assert (low < fit.values).all() and (fit.values < high).all()


def test_derivatives_are_those_of_the_curve(tables):
    points = measured_points({"speed": SPEEDS, "deflection_rms": np.ones(len(SPEEDS))})
    options = {"threads": None, "tables": tables}
    problem = _Problem(manifest(), points, KEYS, None, {}, options)
    computed, noise = problem.curve(problem.start, problem.places)
    assert not noise.any()
    by = problem.jacobian(problem.start, computed, noise)
    assert problem.evaluations == 2, "no difference was needed"
    for key in range(len(KEYS)):
        differences = problem._difference(key, problem.start, computed, noise)
        np.testing.assert_allclose(by[:, key], differences, rtol=1e-3, atol=1e-5 * np.abs(by[:, key]).max())


def test_columns_without_derivatives_are_fitted_by_differences(tables):
    changes = {"mesh.half_gap": 15e-6, "grid.speed": {"values": SPEEDS.tolist()}}
    points = gearatlas.run(manifest(), set=changes, progress=False, tables=tables).points
    measured = {"speed": SPEEDS, "range": points["deflection_pp"]}
    fit = gearatlas.fit(manifest(), measured, ["mesh.half_gap"], column="deflection_pp", tables=tables)
    assert fit.values[0] == pytest.approx(15e-6, rel=1e-4)
    first = points["harmonics"][:, 0]
    fit = gearatlas.fit(manifest(), {"speed": SPEEDS, "harmonics[1]": first}, {"mesh.half_gap": "14 um"}, tables=tables)
    assert fit.values[0] == pytest.approx(15e-6, rel=1e-4)


def test_files_have_units_and_pictures_show_them(curve, tables, tmp_path):
    pytest.importorskip("matplotlib").use("Agg")
    rows = [f"{speed * 30 / np.pi:.17g},{1e6 * value:.17g},0.1" for speed, value in zip(SPEEDS, curve)]
    path = tmp_path / "points.csv"
    path.write_text("\n".join(["speed [rpm],deflection_rms [um],stderr [um]", *rows]) + "\n")
    fit = gearatlas.fit(manifest(), path, KEYS, tables=tables)
    np.testing.assert_allclose(fit.values, list(TRUTH.values()), rtol=1e-5)
    np.testing.assert_allclose(fit.stderr, 1e-7)
    axes = fit.plot()
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("speed [rpm]", "deflection_rms [um]")
    line = axes.get_lines()[0].get_xydata()
    shown = np.interp(SPEEDS * 30 / np.pi, line[:, 0], line[:, 1])
    np.testing.assert_allclose(shown, 1e6 * curve, rtol=1e-5)
    assert "mesh.half_gap = 1.5e-05 ±" in repr(fit)


def test_chaotic_points_weigh_by_their_own_errors(tables):
    chaotic = {"load": {"values": [0.1]}, "speed": {"values": [400.0, 700.0, 800.0]}}
    text = manifest(grid=chaotic, run={"transient": 200, "cycles": 4000})
    text["mesh"]["contact_damping"] = 0.08
    text["excitation"]["transmission_error"][0]["amplitude"] = 5e-6
    points = gearatlas.run(text, progress=False, tables=tables).points
    assert list(points["class"]) == ["periodic", "chaotic", "chaotic"]
    noise = points["deflection_rms_stderr"]
    measured = {"speed": points["speed"], "deflection_rms": points["deflection_rms"], "stderr": np.full(points.rows, 1e-8)}
    problem = _Problem(text, measured_points(measured), ["mesh.contact_damping"], None, {}, {"threads": None, "tables": tables})
    computed, own = problem.curve(problem.start, problem.places)
    np.testing.assert_array_equal(own, np.nan_to_num(noise))
    sigma = _sigma(problem, computed, own)
    np.testing.assert_allclose(sigma**2, 1e-16 + own**2)
    assert own[0] == 0 and (own[1:] > 1e-8).all()


def refused(wanted: str, tables, measured=None, keys=KEYS, source=None, **more) -> None:
    measured = measured or {"speed": SPEEDS, "deflection_rms": np.ones(len(SPEEDS))}
    with pytest.raises(gearatlas.AtlasError, match=wanted):
        gearatlas.fit(source or manifest(), measured, keys, tables=tables, **more)


def test_what_cannot_be_fitted_is_refused(tables):
    points = {"speed": SPEEDS, "deflection_rms": np.ones(len(SPEEDS))}
    refused("`mesh.half_gpa` cannot be fitted; the keys of this manifest are", tables, keys=["mesh.half_gpa"])
    refused("`torque` cannot be fitted", tables, keys=["torque"])
    refused("`speed` is the axis", tables, keys=["speed"])
    refused("each once", tables, keys=["load", "load"])
    refused("1 measured points do not determine 2 keys", tables, {"speed": SPEEDS[:1], "deflection_rms": [1e-5], "e": [1e-6]})
    refused("and their own standard error", tables, {"speed": SPEEDS[:2], "deflection_rms": [1e-5, 1e-5]})
    refused("outside the grid, which goes from", tables, {"speed": SPEEDS + 1000, "deflection_rms": SPEEDS})
    refused("no axis `pressure`", tables, {"pressure": SPEEDS, "deflection_rms": SPEEDS})
    refused("no column of numbers `rms`", tables, {"speed": SPEEDS, "rms": SPEEDS})
    refused("`harmonics` is not a single column", tables, points, column="harmonics")
    refused("standard error 0", tables, {**points, "stderr": np.zeros(len(SPEEDS))})
    refused("is negative", tables, {**points, "stderr": -np.ones(len(SPEEDS))})
    refused("finite numbers", tables, {"speed": SPEEDS, "deflection_rms": np.full(len(SPEEDS), np.nan)})
    refused("inside the bounds", tables, bounds={"mesh.half_gap": (1e-3, 2e-3)})
    millimetres = pint.Quantity([1, 2], "mm")
    refused("inside the bounds", tables, bounds={"mesh.half_gap": tuple(millimetres)})
    refused("from low to high", tables, bounds={"mesh.half_gap": (1e-4, pint.Quantity(10, "um"))})
    two = {"load": {"values": [0.1, 0.2]}, "speed": {"from": SLOWEST, "to": FASTEST, "count": 5}}
    refused("2 values of `load`", tables, source=manifest(grid=two))


def test_keys_that_no_point_depends_on_are_named(tables):
    # At a large load the teeth stay in contact: the half gap moves the mean deflection only.
    grid = {"load": {"values": [5.0]}, "speed": {"from": 300, "to": 500, "count": 5}}
    speeds = np.linspace(300, 500, 5)
    measured = {"speed": speeds, "deflection_rms": np.full(5, 1e-6)}
    refused("do not determine `mesh.half_gap`: deflection_rms does not change", tables, measured, source=manifest(grid=grid))
    points = measured_points({"speed": SPEEDS, "deflection_rms": np.ones(len(SPEEDS))})
    problem = _Problem(manifest(), points, KEYS, None, {}, {"threads": None, "tables": tables})
    good, poor = (np.array([[1.0, 2.0], [2.0, 4.0], [3.0, last]]) for last in (6.1, 6.0))
    problem.check_determined(good, good)
    with pytest.raises(gearatlas.AtlasError, match="only a combination of `mesh.contact_damping`, `mesh.half_gap`"):
        problem.check_determined(poor, poor)
    # A difference of a value without noise is round-off, which a single key would be fitted to.
    with pytest.raises(gearatlas.AtlasError, match="do not determine `mesh.half_gap`"):
        problem.check_determined(good, good * [1.0, 1e-10])


def test_sensitivities_are_a_table(tables):
    point = gearatlas.load(manifest()).point()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = gearatlas.sensitivity(point, ["mesh.half_gap", "load"], tables=tables)
    rows = found.rows.to_dicts()
    assert found.motion and {row["key"] for row in rows} == {"mesh.half_gap", "load"}
    rms = next(row for row in rows if (row["key"], row["quantity"]) == ("mesh.half_gap", "deflection_rms"))
    assert rms["derivative"] == pytest.approx(rms["check"], rel=1e-4) and rms["unit"] == "m"
    # A changed point is differentiated where it is, not at the values of the manifest.
    changed = point.changed(TRUTH, speed=SPEEDS[5])
    for row in gearatlas.sensitivity(changed, KEYS, tables=tables).rows.to_dicts():
        if row["quantity"] == "deflection_rms":
            assert row["at"] == TRUTH[row["key"]] and row["note"] == ""
            assert row["derivative"] == pytest.approx(row["check"], rel=1e-4)
    with pytest.raises(gearatlas.AtlasError, match="half_gpa"):
        gearatlas.sensitivity(point, ["mesh.half_gpa"])

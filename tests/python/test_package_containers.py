"""Results as containers: sequences, mappings, arrays, xarray, pickles, quantities, pictures, and the examples in docstrings."""

import contextlib
import doctest
import importlib.util
import os
import pickle
import pkgutil
import sys
from html.parser import HTMLParser
from pathlib import Path

import matplotlib
import numpy as np
import pint
import polars as pl
import pytest
import xarray
from joblib import Parallel, delayed

import gearatlas
from gearatlas._html import html_table
from gearatlas._layout import Layout
from gearatlas._measured import measured_points
from gearatlas._gearatlas import conversion
from gearatlas._pint import parts, plain
from gearatlas._table import _known
from program import ROOT, same_bits

matplotlib.use("Agg")

QUICKSTART = ROOT / "manifests/quickstart.toml"
OSCILLATOR = ROOT / "tests/data/oscillator.toml"
SHORT = {"run.transient": 20, "run.cycles": 60, "analyses.lyapunov": None}
AXES = ["load", "speed"]


@pytest.fixture(scope="module")
def cache(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("tables")


@pytest.fixture(scope="module")
def results(tmp_path_factory, cache) -> gearatlas.Results:
    return gearatlas.run(OSCILLATOR, tmp_path_factory.mktemp("out") / "run", tables=cache, progress=False)


@pytest.fixture(scope="module")
def both(cache) -> gearatlas.Results:
    """A sweep up and down."""
    return gearatlas.run(OSCILLATOR, set={"grid.order": "both", **SHORT}, tables=cache, progress=False)


@pytest.fixture(scope="module")
def followed(cache) -> gearatlas.Results:
    text = (ROOT / "tests/manifests/oscillator.head.toml").read_text().replace('file = "', f'file = "{ROOT}/tests/manifests/')
    grid = "speed = { from = 600, to = 1500, count = 10 }\nload = { values = [0.05, 0.1] }"
    text += f'\ntransient = 300\n[grid]\n{grid}\n[continuation]\nover = "speed"\nstarts = 4\n'
    return gearatlas.follow(text, tables=cache)


@pytest.fixture(scope="module")
def chaotic(cache) -> gearatlas.Results:
    """Periodic and chaotic points, the latter with standard errors."""
    loads = {"grid.load": {"values": [0.1, 0.2]}}
    return gearatlas.run(QUICKSTART, set={"run.cycles": 4000, **loads}, tables=cache, progress=False)


@contextlib.contextmanager
def figure():
    """Axes of Matplotlib for one picture."""
    import matplotlib.pyplot as plt

    try:
        yield plt.subplots()[1]
    finally:
        plt.close("all")


# ---- tables as sequences


def test_a_table_is_a_sequence_of_rows(results):
    points = results.points
    rows = list(points)
    assert len(points) == len(rows) == np.asarray(points).shape[0] == points.rows == 6
    assert rows == points.to_dicts() == [points[i] for i in range(6)]
    assert points[-1] == rows[5] and points[np.int64(2)] == rows[2]
    assert all(row in points for row in rows) and all(name in points for name in points.columns)
    assert {**rows[0], "speed": 1.0} not in points and "speeds" not in points and 0 not in points
    for wrong in (6, -7):
        with pytest.raises(IndexError, match=f"there is no row {wrong}"):
            points[wrong]
    # Polars reads the rows on its own.
    assert rows == pl.DataFrame(points).to_dicts()
    assert list(map(_known, [[1.0, np.nan, np.nan], [np.nan, 2.0], [np.nan], [], "x"])) == [[1.0], [None, 2.0], None, None, "x"]


def test_rows_and_columns_are_taken(results):
    samples = results.poincare
    frame = samples.to_polars()
    late = samples["cycle"] > np.median(samples["cycle"])
    for rows, wanted in [
        (slice(3, 50, 7), frame[3:50:7]),
        (slice(None, None, -1), frame.reverse()),
        (late, frame.filter(pl.Series(late))),
        ([5, 0, 5], frame[[5, 0, 5]]),
        ([], frame[:0]),
    ]:
        taken = samples[rows]
        assert taken.to_polars().equals(wanted) and len(taken) == wanted.height
        assert taken.units == samples.units and taken.metadata == samples.metadata
    names = ["velocity", "deflection"]
    assert samples[names].columns == names
    assert samples[names][late].to_polars().equals(frame.filter(pl.Series(late)).select(names))
    with pytest.raises(KeyError, match="velocities"):
        samples[["deflection", "velocities"]]
    with pytest.raises(IndexError):
        samples[np.zeros((2, 2), int)]


def test_an_array_has_the_columns_of_the_table(results):
    points = results.points
    array = np.asarray(points)
    assert array.dtype.names == tuple(points.columns)
    for name in points.columns:
        np.testing.assert_array_equal(array[name], points[name])
    matrix = np.asarray(points[["load", "speed", "harmonics"]], float)
    np.testing.assert_array_equal(matrix, np.column_stack([points["load"], points["speed"], points["harmonics"]]))
    with pytest.raises(ValueError, match="copying"):
        np.asarray(points, copy=False)


def test_elements_of_lists_have_names(results):
    points = results.points
    np.testing.assert_array_equal(points["harmonics[2]"], points["harmonics"][:, 1])
    np.testing.assert_array_equal(points["contact_force[coast flank]"], points["contact_force[2]"])
    assert points.unit("harmonics[2]") == points.units["harmonics"] == "m"
    np.testing.assert_array_equal(points.on_grid("harmonics[1]").ravel(), points["harmonics"][:, 0])
    for wrong in ("harmonics[0]", "harmonics[6]", "load[1]", "contact_force[left]"):
        with pytest.raises(KeyError):
            points[wrong]
    with pytest.raises(ValueError, match=r"harmonics\[1\]"):
        points.on_grid("harmonics")


def test_results_are_a_mapping_of_tables(results):
    assert list(results) == results.tables and len(results) == len(dict(results)) == 3
    assert "points" in results and "branches" not in results
    assert results["spectra"] is results.spectra and results.get("branches") is None
    with pytest.raises(KeyError, match="branches"):
        results["branches"]
    assert gearatlas.Results.points.__doc__ == "One row per operating point."
    assert results != gearatlas.open(results.folder) and results in {results}


# ---- xarray


def test_planes_have_coordinates(results):
    plane = results.to_xarray()
    assert dict(plane.sizes)["load"] == 2 and dict(plane.sizes)["speed"] == 3
    for row in results.points:
        here = plane.sel(load=row["load"], speed=row["speed"])
        assert here["point_id"] == row["point_id"] and here["class"].item() == row["class"]
        np.testing.assert_array_equal(here["harmonics"].sel(harmonics_number=3), row["harmonics"][2])
        np.testing.assert_array_equal(here["contact_force"].sel(contact="drive flank"), row["contact_force"][0])
    assert plane["deflection_rms"].attrs["units"] == "m" and "deflection" in plane["deflection_rms"].attrs["description"]
    assert plane["speed"].attrs["units"] == "rad/s" and plane["point_id"].dtype == np.uint64
    # What belongs together shares its dimension; lists that are empty everywhere are left out.
    assert plane["contact_force"].dims == plane["contact_fraction"].dims == (*AXES, "contact")
    assert not [name for name in plane if 0 in plane[name].shape]


def test_a_list_and_its_errors_share_a_dimension(chaotic):
    plane = chaotic.to_xarray()
    assert plane["exponents"].dims == plane["exponents_stderr"].dims == (*AXES, "exponents_number")
    assert plane["harmonics"].dims == plane["harmonics_stderr"].dims == (*AXES, "harmonics_number")
    known = (plane["harmonics_stderr"] / plane["harmonics"]).notnull().any("harmonics_number")
    np.testing.assert_array_equal(known, chaotic.points.on_grid("class") == "chaotic")


def test_points_that_are_missing_leave_gaps(results):
    plane = results.points[[0, 1, 2, 4]].to_xarray()
    assert np.isnan(plane["point_id"]).values.tolist() == [[False, False, False], [True, False, True]]
    assert plane["class"].isnull().values.tolist() == [[False, False, False], [True, False, True]]


def test_samples_of_a_point_are_counted(results):
    samples = results.to_xarray("poincare")
    assert samples["deflection"].dims == (*AXES, "row")
    for row in results.points:
        own = samples["deflection"].sel(load=row["load"], speed=row["speed"]).dropna("row")
        np.testing.assert_array_equal(own, results.poincare["deflection"][results.poincare["point_id"] == row["point_id"]])
    assert results.poincare.to_xarray().sizes == {"row": len(results.poincare)}


def test_a_sweep_in_both_directions_has_a_dimension(both):
    plane = both.to_xarray()
    assert plane["deflection_rms"].dims == ("direction", *AXES)
    for way in ("up", "down"):
        np.testing.assert_array_equal(plane["deflection_rms"].sel(direction=way), both.points.on_grid("deflection_rms", way))


def test_tied_axes_and_distributions_share_a_dimension(cache):
    changes = {"grid.load": {"values": [0.2, 0.1, 0.1]}, "grid.tied": [AXES], "grid.\"mesh.half_gap\"": {"values": [1e-5, 2e-5]}}
    found = gearatlas.run(OSCILLATOR, set={**changes, **SHORT}, tables=cache, progress=False).to_xarray()
    assert found["deflection_rms"].dims == ("mesh.half_gap", "load") and found["speed"].dims == ("load",)
    assert found["load"].values.tolist() == [0.1, 0.1, 0.2]
    assert found["speed"].values.tolist() == [1050.0, 1500.0, 600.0]

    changes = {"grid.samples": 4, "grid.\"mesh.half_gap\"": {"uniform": [1e-5, 2e-5]}, "grid.load": 0.1}
    results = gearatlas.run(OSCILLATOR, set={**changes, **SHORT}, tables=cache, progress=False)
    found = results.to_xarray()
    assert found["deflection_rms"].dims == ("sample", *AXES) and found["mesh.half_gap"].dims == ("sample",)
    for row in results.points:
        here = found.sel(sample=row["sample"], speed=row["speed"], load=row["load"])
        assert (here["mesh.half_gap"], here["point_id"]) == (row["mesh.half_gap"], row["point_id"])


def test_branches_are_the_rows_of_an_array(followed):
    found = followed.to_xarray("branches")
    assert found["deflection_rms"].dims == found["speed"].dims == ("branch", "row") and "speed" in found.coords
    for number in found["branch"].values:
        own = followed.branches[followed.branches["branch"] == number]
        np.testing.assert_array_equal(found["speed"].sel(branch=number).dropna("row"), own["speed"])


def test_a_table_without_axes_has_rows(cache):
    point = gearatlas.load(OSCILLATOR).point(2)
    traced = gearatlas.trace(point, cycles=2, skip=5, tables=cache)
    assert traced.samples.to_xarray().sizes == {"row": 128}
    assert traced.samples[:0].to_xarray().sizes == {"row": 0}
    assert gearatlas.load(OSCILLATOR).grid.to_xarray()["point_id"].values.tolist() == [[0, 1, 2], [3, 4, 5]]


def test_equal_keys_are_counted_in_order():
    layout = Layout.along([{"key": np.array([3, 1, 3, 3, 1])}], 5)
    assert layout.dims["key"].tolist() == [1, 3] and layout.dims["row"].tolist() == [0, 1, 2]
    expected = [[20, 50, np.nan], [10, 30, 40]]
    np.testing.assert_array_equal(layout.array(np.array([10, 20, 30, 40, 50])), expected)


@pytest.mark.parametrize("module, call", [("xarray", "to_xarray"), ("matplotlib.pyplot", "plot")])
def test_optional_packages_are_named(results, monkeypatch, module, call):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ImportError, match=f"pip install {module.partition('.')[0]}"):
        getattr(results, call)()


# ---- pickles


def test_manifests_and_points_are_pickled(monkeypatch, tmp_path):
    monkeypatch.chdir(OSCILLATOR.parent)
    manifest = gearatlas.load("oscillator.toml", set={"mesh.half_gap": "20 um", "analyses.poincare": None})
    point = manifest.point(4, {"mesh.half_gap": 12e-6})
    sent = pickle.dumps(manifest)
    monkeypatch.chdir(tmp_path)
    again = pickle.loads(sent)
    assert (again.hash, again.text, again.changes) == (manifest.hash, manifest.text, manifest.changes)
    other = pickle.loads(pickle.dumps(point))
    assert other.id == 4 and [other[key] for key in manifest.keys] == [point[key] for key in manifest.keys]
    # Load and torque are one quantity, whichever came last.
    point = gearatlas.load(QUICKSTART).point(5, torque=3.0)
    for changed in (point, point.changed(load=0.123), point.changed(load=0.123).changed(torque=4.0)):
        other = pickle.loads(pickle.dumps(changed))
        assert (repr(other), other.load) == (repr(changed), changed.load) and changed.load in (3 / 50, 0.123, 4 / 50)


def test_a_pickled_manifest_needs_the_same_files(tmp_path):
    text = (OSCILLATOR.parent / "oscillator.modal.toml").read_text()
    (tmp_path / "oscillator.modal.toml").write_text(text)
    (tmp_path / "m.toml").write_text(OSCILLATOR.read_text())
    sent = pickle.dumps(gearatlas.load(tmp_path / "m.toml"))
    (tmp_path / "oscillator.modal.toml").write_text(text.replace("0.877", "0.9"))
    with pytest.raises(gearatlas.AtlasError, match="have changed since it was pickled"):
        pickle.loads(sent)
    (tmp_path / "oscillator.modal.toml").unlink()
    with pytest.raises(gearatlas.ManifestError, match="oscillator.modal.toml"):
        pickle.loads(sent)


def test_tables_are_pickled(results):
    for table in (results.points, results.poincare, results.points[:0]):
        again = pickle.loads(pickle.dumps(table))
        assert again.to_pyarrow().equals(table.to_pyarrow(), check_metadata=True)


def test_results_are_pickled(results, both):
    again = pickle.loads(pickle.dumps(results))
    assert again.folder == results.folder and again.points.to_polars().equals(results.points.to_polars())
    # The files of a temporary folder travel, and live as long as their object.
    again = pickle.loads(pickle.dumps(both))
    folder = again.folder
    assert folder != both.folder and again.record == both.record
    same_bits(again.points.to_pyarrow(), both.points.to_pyarrow())
    del again
    assert not folder.exists()


def worked(point: gearatlas.Point, cache: Path) -> tuple[int, np.ndarray, gearatlas.Results]:
    """What a worker of joblib does: a cycle of a point, and a run of its own."""
    cycle = pickle.loads(pickle.dumps(gearatlas.CycleMap(point, threads=1, tables=cache)))
    run = gearatlas.run(OSCILLATOR, set={"grid.load": point.load, **SHORT}, threads=1, tables=cache, progress=False)
    return os.getpid(), cycle(cycle.start(), 5), run


def test_joblib_sends_points_and_brings_results(cache):
    manifest = gearatlas.load(OSCILLATOR)
    points = [manifest.point(0), manifest.point(3, {"mesh.half_gap": 11e-6})]
    found = Parallel(n_jobs=2)(delayed(worked)(point, cache) for point in points)
    for point, (process, state, run) in zip(points, found, strict=True):
        _, here, wanted = worked(point, cache)
        assert process != os.getpid()
        np.testing.assert_array_equal(state, here)
        same_bits(run.points.to_pyarrow(), wanted.points.to_pyarrow())


# ---- quantities of pint


def test_quantities_are_values_of_keys():
    unit = pint.get_application_registry()
    texts = {"mesh.half_gap": "20 um", "mesh.mean_stiffness": "400 N/um", "grid.speed": ["6000 rpm", "9000 rpm"], "grid.load": "10 %"}
    quantities = {
        "mesh.half_gap": unit.Quantity(20, "um"),
        "mesh.mean_stiffness": unit.Quantity(400, "N/um"),
        "grid.speed": {"values": unit.Quantity([6000, 9000], "rpm")},
        "grid.load": unit.Quantity(10, "percent"),
    }
    texts["grid.speed"] = {"values": texts["grid.speed"]}
    assert gearatlas.load(OSCILLATOR, quantities).hash == gearatlas.load(OSCILLATOR, texts).hash
    # Units that manifests do not know, through SI.
    inch = gearatlas.load(OSCILLATOR, {"mesh.half_gap": unit.Quantity(1e-3, "inch")})
    assert inch.point()["mesh.half_gap"] == pytest.approx(25.4e-6, rel=1e-14)
    point = gearatlas.load(QUICKSTART).point(speed=unit.Quantity(3000, "rpm"), torque=unit.Quantity(20, "lbf*inch"))
    assert point.speed == pytest.approx(100 * np.pi) and point.load == pytest.approx(20 * 4.4482216152605 * 0.0254 / 50)
    assert plain([unit.Quantity(0.5, ""), {"a": 3}, "x"]) == [0.5, {"a": 3}, "x"]
    with pytest.raises(gearatlas.ManifestError, match="kg"):
        gearatlas.load(OSCILLATOR, {"mesh.half_gap": unit.Quantity(1, "kg")})
    with pytest.raises(gearatlas.AtlasError, match="kg"):
        inch.point(speed=unit.Quantity(1, "kg"))


@pytest.mark.parametrize("unit", ["um", "N/um", "kN*mm", "deg", "mrad", "rpm", "GPa", "mPa*s", "g/cm^3", "kg*mm^2", "N*m/deg", "%", "min", "inch"])
def test_units_mean_the_same_to_pint_and_to_manifests(unit):
    quantity = pint.Quantity(3.0, unit)
    number, text = parts(quantity)
    base = quantity.to_base_units()
    assert number * conversion(text, f"{base.units:~C}".replace("**", "^") or "%") == pytest.approx(base.magnitude * (100 if unit == "%" else 1), rel=1e-14)


def test_measured_points_may_be_quantities():
    unit = pint.get_application_registry()
    found = measured_points({"speed": unit.Quantity([6000, 9000], "rpm"), "rms": unit.Quantity([1, 2], "thou"), "error": [1e-7, 2e-7]})
    np.testing.assert_allclose(found.axis.in_si("rad/s"), [200 * np.pi, 300 * np.pi])
    np.testing.assert_allclose(found.value.in_si("m"), [25.4e-6, 50.8e-6])
    assert found.axis.unit == "rpm" and found.stderr.in_si("m").tolist() == [1e-7, 2e-7]
    with pytest.raises(gearatlas.AtlasError, match="does not fit speed"):
        found.axis.in_si("N")


# ---- sweeps


def test_a_sweep_is_a_manifest_with_its_axes(cache, tmp_path):
    speed = pint.get_application_registry().Quantity([6000, 8000, 7000], "rpm")
    axes = {"mesh.half_gap": ("10 um", 2e-5)}
    found = gearatlas.sweep(OSCILLATOR, axes, tmp_path / "out", set=SHORT, speed=speed, load=0.1, tables=cache, progress=False)
    text = OSCILLATOR.read_text()
    grid = '[grid]\n"mesh.half_gap" = { values = ["10 um", "20 um"] }\nload = 0.1\nspeed = { values = ["6000 rpm", "8000 rpm", "7000 rpm"] }\n'
    written = gearatlas.Manifest.from_text(text.split("[grid]")[0] + grid + "[run]" + text.split("[run]")[1], SHORT, OSCILLATOR.parent)
    assert found.record["manifest_hash"] == written.hash and found.folder == tmp_path / "out"
    assert found.points.on_grid("deflection_rms").shape == (2, 1, 3)
    # Of a manifest that is loaded already, with its own other axes, and a range.
    manifest = gearatlas.load(OSCILLATOR, set=SHORT)
    found = gearatlas.sweep(manifest, speed={"from": 600, "to": 700, "count": 2}, tables=cache, progress=False)
    assert found.to_xarray().sizes["load"] == 2 and found.to_xarray()["speed"].values.tolist() == [600, 700]
    with pytest.raises(gearatlas.ManifestError, match="half_gpa"):
        gearatlas.sweep(manifest, {"mesh.half_gpa": [1e-5]}, tables=cache, progress=False)


def test_a_loaded_manifest_is_changed():
    changed = gearatlas.load(gearatlas.load(OSCILLATOR, set={"run.cycles": 99}), set={"mesh.half_gap": "20 um"})
    assert changed.hash == gearatlas.load(OSCILLATOR, set={"run.cycles": 99, "mesh.half_gap": "20 um"}).hash


# ---- notebooks


class Cells(HTMLParser):
    """The texts of the cells of a table."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.cells: dict[str, list[str]] = {"th": [], "td": [], "p": []}
        self.tag = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tag = tag
        if tag in self.cells:
            self.cells[tag].append("")

    def handle_endtag(self, tag):
        self.tag = ""

    def handle_data(self, data):
        self.cells[self.tag][-1] += data


def test_notebooks_show_tables(results, followed):
    shown = Cells(results.points._repr_html_()).cells
    assert shown["th"][:3] == ["point_id", "load", "speed [rad/s]"] and len(shown["td"]) == 6 * len(shown["th"])
    assert shown["td"][1] == "0.05" and shown["p"] == [f"6 rows, {len(results.points.columns)} columns; shown are 6 rows and 16 columns"]
    grid = Cells(gearatlas.load(OSCILLATOR).grid._repr_html_()).cells
    assert grid["td"][:3] == ["0", "0.05", "600"] and grid["p"] == ["6 rows, 3 columns"]
    tables = Cells(results._repr_html_()).cells
    assert tables["td"][::3] == results.tables and tables["td"][1::3] == [str(len(results[name])) for name in results]
    axes = Cells(gearatlas.load(OSCILLATOR)._repr_html_()).cells
    assert axes["td"] == ["load", "1", "2", "0.05", "0.3", "speed", "rad/s", "3", "600", "1500"]
    # Texts may have signs of HTML.
    assert Cells(html_table(["<i>"], [["a<b&c"], [None], [[1, 2.5]]], "x")).cells == {"th": ["<i>"], "td": ["a<b&c", "", "1, 2.5"], "p": ["x"]}
    assert len(Cells(results.points[:0]._repr_html_()).cells["td"]) == 0


# ---- pictures


def test_two_axes_are_a_map(results):
    with figure() as axes:
        assert results.plot("deflection_rms", units={"speed": "rpm", "deflection_rms": "um"}, axes=axes, cmap="magma") is axes
        [mesh] = axes.collections
        np.testing.assert_allclose(mesh.get_array(), 1e6 * results.points.on_grid("deflection_rms"), rtol=1e-14)
        assert (axes.get_xlabel(), axes.get_ylabel(), mesh.cmap.name) == ("speed [rpm]", "load", "magma")
        assert axes.figure.axes[1].get_ylabel() == "deflection_rms [um]"
        # The cells have their points in the middle.
        middle = mesh.get_coordinates()[0, :, 0]
        np.testing.assert_allclose((middle[1:] + middle[:-1])[1] / 2, 1050 * 30 / np.pi)
    with figure() as axes:
        results.plot("harmonics[1]", over=["speed", "load"], axes=axes)
        np.testing.assert_array_equal(axes.collections[0].get_array(), results.points.on_grid("harmonics[1]").T)
        assert axes.get_ylabel() == "speed [rad/s]"


def test_a_refined_plane_is_dots(cache):
    refine = {"by": ["deflection_rms"], "tolerance": 0.3, "levels": 2}
    results = gearatlas.run(QUICKSTART, set={"model.modes": 2, "run.cycles": 500, "grid.refine": refine}, tables=cache, progress=False)
    with figure() as axes:
        results.plot("force_peak", axes=axes)
        [dots] = axes.collections
        points = results.points
        assert 12 < len(points) < 9 * 13
        np.testing.assert_array_equal(dots.get_offsets(), np.column_stack([points["speed"], points["load"]]))
        np.testing.assert_array_equal(dots.get_array(), points["force_peak"])


def test_texts_are_colours_with_names(chaotic):
    with figure() as axes:
        chaotic.plot("class", axes=axes)
        names = [label.get_text() for label in axes.figure.axes[1].get_yticklabels()]
        shown = np.array(names)[np.asarray(axes.collections[0].get_array(), int)]
        assert len(names) > 1
        np.testing.assert_array_equal(shown, chaotic.points.on_grid("class"))


def test_one_axis_is_a_curve_with_errors(chaotic):
    points = chaotic.points[chaotic.points["load"] == 0.2]
    with figure() as axes:
        chaotic.plot(axes=axes, at={"load": 0.2})
        [drawn] = axes.containers
        line, _, [bars] = drawn.lines
        np.testing.assert_array_equal(line.get_xydata(), np.column_stack([points["speed"], points["lambda_max"]]))
        assert axes.get_ylabel() == "lambda_max [1/cycle]" and (points["lambda_stderr"] > 0).any()
        for segment, value, error in zip(bars.get_segments(), points["lambda_max"], points["lambda_stderr"], strict=True):
            if error > 0:
                np.testing.assert_allclose(segment[:, 1], [value - error, value + error])


def test_curves_have_names(results, both):
    with figure() as axes:
        results.plot("force_peak", over="speed", axes=axes, units={"force_peak": "kN"})
        labels = [text.get_text() for text in axes.get_legend().get_texts()]
        assert labels == ["load = 0.05", "load = 0.3"]
        for drawn, load in zip(axes.containers, (0.05, 0.3), strict=True):
            own = results.points[np.isclose(results.points["load"], load)]
            np.testing.assert_allclose(drawn.lines[0].get_ydata(), own["force_peak"] / 1e3)
    with figure() as axes:
        both.plot("deflection_rms", at={"load": 0.1}, axes=axes)
        assert [text.get_text() for text in axes.get_legend().get_texts()] == ["direction = down", "direction = up"]
        assert axes.get_title() == "load = 0.05"
        assert np.all(np.diff(axes.containers[0].lines[0].get_xdata()) > 0)


def test_samples_are_dots(results):
    speed = pint.get_application_registry().Quantity(10000, "rpm")
    with figure() as axes:
        results.plot("deflection", table="poincare", at={"load": 0.3}, axes=axes)
        [line] = axes.lines
        assert len(line.get_xdata()) == np.isin(results.poincare["point_id"], [3, 4, 5]).sum()
        assert line.get_linestyle() == "None" and axes.get_title() == "load = 0.3"
    with figure() as axes:
        results.plot("velocity", table="poincare", over="deflection", at={"load": 0.3, "speed": speed}, axes=axes, units={"speed": "rpm"})
        own = results.poincare["point_id"] == 4
        assert sorted(axes.lines[0].get_ydata()) == sorted(results.poincare["velocity"][own])
        assert axes.get_title() == f"load = 0.3, speed = {1050 * 30 / np.pi:.4g} rpm" and axes.get_xlabel() == "deflection [m]"


def test_trajectories_are_lines_over_time(cache):
    samples = gearatlas.trace(gearatlas.load(OSCILLATOR).point(2), cycles=2, skip=5, tables=cache).samples
    with figure() as axes:
        samples.plot("force", axes=axes)
        np.testing.assert_array_equal(axes.containers[0].lines[0].get_xydata(), np.column_stack([samples["time"], samples["force"]]))


def test_unstable_orbits_are_dashed(followed):
    branches = followed.branches
    with figure() as axes:
        followed.plot("deflection_max", axes=axes)
        drawn = {style: [line.get_ydata() for line in axes.lines if line.get_linestyle() == style] for style in ("-", "--")}
        assert axes.get_xlabel() == "speed [rad/s]"
        solid, dashed = (np.concatenate(found) for found in drawn.values())
        stable = branches["stable"].astype(bool)
        assert 0 < stable.sum() < len(branches)
        assert set(solid[~np.isnan(solid)]) == set(branches["deflection_max"][stable])
        assert set(dashed[~np.isnan(dashed)]) >= set(branches["deflection_max"][~stable])


def test_pictures_that_are_not_clear_are_refused(results, both):
    with pytest.raises(gearatlas.AtlasError, match="direction vary too"):
        both.plot("deflection_rms")
    with pytest.raises(gearatlas.AtlasError, match="load, speed vary"):
        results.plot("deflection", table="poincare")
    with pytest.raises(gearatlas.AtlasError, match="single operating point"):
        results.points[:1].plot("deflection_rms")
    with pytest.raises(gearatlas.AtlasError, match="no rows"):
        results.points[:0].plot()
    with pytest.raises(gearatlas.AtlasError, match="`kg` is not a unit of speed"):
        results.plot(units={"speed": "kg"})
    with pytest.raises(gearatlas.AtlasError, match=r"`speed \[kg\]` does not fit speed"):
        results.plot("force_peak", at={"speed": pint.Quantity(1, "kg")})
    with pytest.raises(gearatlas.AtlasError, match="direction = sideways"):
        both.plot(at={"direction": "sideways"})
    with pytest.raises(KeyError, match="deflection_rsm"):
        results.plot("deflection_rsm")


# ---- examples


def test_the_example_draws_a_plane(monkeypatch, tmp_path, capsys):
    spec = importlib.util.spec_from_file_location("bifurcation_plane", ROOT / "examples/bifurcation_plane.py")
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    monkeypatch.chdir(tmp_path)
    results = example.plane(4, 5)
    monkeypatch.setattr(example, "plane", lambda: results)
    monkeypatch.setattr(sys, "argv", ["bifurcation_plane.py", "plane.png"])
    with figure():
        example.main()
    assert f"{np.mean(results.points['class'] == 'chaotic'):.0%} of 20 points are chaotic" in capsys.readouterr().out
    assert (tmp_path / "plane.png").read_bytes().startswith(b"\x89PNG")


def examples() -> list[str]:
    names = [f"gearatlas.{module.name}" for module in pkgutil.iter_modules(gearatlas.__path__)]
    modules = [importlib.import_module(name) for name in ["gearatlas", *names] if name != "gearatlas.ross"]
    found = [module for module in modules if any(test.examples for test in doctest.DocTestFinder().find(module))]
    return [module.__name__ for module in found]


def test_docstrings_have_examples():
    assert {"gearatlas", "gearatlas._table", "gearatlas._results", "gearatlas._manifest", "gearatlas._run"} <= set(examples())


@pytest.fixture(scope="module")
def workplace(tmp_path_factory) -> Path:
    """A folder in which examples read manifests and keep results."""
    folder = tmp_path_factory.mktemp("examples")
    (folder / "manifests").symlink_to(ROOT / "manifests")
    return folder


@pytest.mark.parametrize("name", examples())
def test_examples_of_docstrings_show_what_they_print(name, monkeypatch, workplace):
    monkeypatch.chdir(workplace)
    found = doctest.testmod(importlib.import_module(name))
    assert found.failed == 0 and found.attempted > 0

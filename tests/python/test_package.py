"""The Python package `atlas`: manifests and their faults, runs, tables for whoever takes Arrow.

`scripts/test` builds and installs it first; ATLAS_SAMPLE_RESULTS names what the command line computed
of manifests/quickstart.toml."""

import json
import os
import subprocess
import tomllib
from pathlib import Path

import duckdb
import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

import gearatlas
from program import ATLAS, ROOT, same_bits

QUICKSTART = ROOT / "manifests/quickstart.toml"
OSCILLATOR = ROOT / "tests/data/oscillator.toml"


@pytest.fixture(scope="module")
def results(tmp_path_factory) -> gearatlas.Results:
    tables = tmp_path_factory.mktemp("tables")
    return gearatlas.run(QUICKSTART, tmp_path_factory.mktemp("out") / "run", tables=tables, progress=False)


@pytest.fixture(scope="module")
def by_command_line() -> Path:
    folder = os.environ.get("ATLAS_SAMPLE_RESULTS")
    if not folder:
        pytest.skip("ATLAS_SAMPLE_RESULTS names no folder; scripts/test does")
    return Path(folder)


# ---- manifests


def test_a_file_a_text_and_a_dictionary_are_one_manifest():
    text = QUICKSTART.read_text()
    manifests = [gearatlas.load(QUICKSTART), gearatlas.load(str(QUICKSTART)), gearatlas.load(text), gearatlas.load(tomllib.loads(text))]
    assert len({manifest.hash for manifest in manifests}) == 1
    assert all(len(manifest) == 12 and manifest.name == "quickstart" for manifest in manifests)


def test_points_are_listed():
    manifest = gearatlas.load(QUICKSTART)
    load, speed = manifest.axes
    assert (load.name, load.unit, speed.name, speed.unit) == ("load", "1", "speed", "rad/s")
    np.testing.assert_allclose(load.values, [0.1, 0.2, 0.3])
    assert manifest.points[5] == {"point_id": 5, "load": load.values[1], "speed": speed.values[1]}
    assert manifest.grid.units == {"point_id": "1", "load": "1", "speed": "rad/s"}
    assert pa.table(manifest.grid).num_rows == 12


def test_keys_are_set_as_on_the_command_line():
    changed = gearatlas.load(QUICKSTART, set={"mesh.half_gap": "20 um", "run.cycles": 2000, "grid.load": {"values": [0.1, 0.2]}})
    assert changed.point()["mesh.half_gap"] == pytest.approx(20e-6)
    assert len(changed) == 8 and "run.cycles=2000" in changed.changes
    dropped = gearatlas.load(QUICKSTART, set={"analyses.poincare": None})
    assert dropped.hash != gearatlas.load(QUICKSTART).hash
    as_typed = ["mesh.half_gap=\"20 um\"", "run.cycles=2000", "grid.load={ values = [0.1, 0.2] }"]
    options = [word for change in as_typed for word in ("--set", change)]
    told = subprocess.run([ATLAS, "check", QUICKSTART, "--json", *options], capture_output=True, text=True, check=True)
    assert changed.hash in told.stdout


@pytest.mark.parametrize("name", ["wrong_unit", "unknown_key", "missing_tables", "many_faults", "syntax"])
def test_faults_are_those_of_the_command_line(name, tmp_path):
    if name in ("many_faults", "syntax"):
        path = tmp_path / "m.toml"
        bad = "half_gap = = 3" if name == "syntax" else 'half_gap = "10 kg"\nhalf_gpa = 3'
        path.write_text(QUICKSTART.read_text().replace('half_gap = "10 um"', bad))
    else:
        path = ROOT / f"tests/manifests/bad/{name}.toml"
    told = subprocess.run([ATLAS, "run", path], capture_output=True, text=True)
    assert told.returncode == 2
    with pytest.raises(gearatlas.ManifestError) as raised:
        gearatlas.load(path)
    assert str(raised.value) + "\n" == told.stderr
    error = raised.value
    assert error.count >= len(error.faults) >= 1 and isinstance(error, ValueError)
    if name == "many_faults":
        assert error.count >= 2
        by_key = {fault.key: fault for fault in error.faults}
        unit = by_key["mesh.half_gap"]
        line = path.read_text().splitlines().index('half_gap = "10 kg"') + 1
        assert (unit.kind, unit.line, unit.source) == ("wrong-unit", line, str(path))
        assert by_key["mesh.half_gpa"].nearest == "`half_gap`"


def test_faults_of_a_dictionary_show_its_text():
    tables = tomllib.loads(QUICKSTART.read_text())
    tables["mesh"]["half_gap"] = "10 kg"
    with pytest.raises(gearatlas.ManifestError, match='half_gap = "10 kg"') as raised:
        gearatlas.load(tables)
    assert raised.value.faults[0].source == "dict"
    tables["mesh"]["half_gap"] = object()
    with pytest.raises(TypeError, match="mesh.half_gap is a object"):
        gearatlas.load(tables)


def test_keys_without_effect_are_warnings():
    text = QUICKSTART.read_text().replace('stiffness = "piecewise"', 'stiffness = "constant"')
    with pytest.warns(gearatlas.ManifestWarning) as caught:
        manifest = gearatlas.load(text)
    [warning] = caught
    assert warning.filename == __file__
    keys = [fault.key for fault in manifest.warnings]
    assert keys[:2] == ["mesh.contact_ratio", "mesh.single_pair_drop"]
    line = next(n for n, row in enumerate(text.splitlines(), 1) if row.startswith("contact_ratio"))
    first = manifest.warnings[0]
    assert (first.kind, first.source, first.line) == ("no-effect", "text", line)
    assert first.remedy == 'remove it, or set stiffness = "piecewise"'
    assert all(str(warning.message).count(f"`{key}` has no effect") == 1 for key in keys)
    assert gearatlas.load(QUICKSTART).warnings == []


def test_a_table_that_was_not_computed_is_told_how_to_have_it(tmp_path):
    text = OSCILLATOR.read_text().replace("cycles = 300", "cycles = 100\naudit_cycles = 5")
    text = text.split("[analyses]")[0] + "[analyses]\nnvh = {}\n"
    (tmp_path / "m.toml").write_text(text)
    (tmp_path / "oscillator.modal.toml").write_text((OSCILLATOR.parent / "oscillator.modal.toml").read_text())
    plain = gearatlas.run(tmp_path / "m.toml", tmp_path / "run", tables=tmp_path / "tables", progress=False)
    with pytest.raises(gearatlas.AtlasError, match=r"no spectra\.parquet in .*`nvh = \{ spectrum = \{\} \}`.*available are points"):
        _ = plain.spectra
    with pytest.raises(gearatlas.AtlasError, match="`atlas follow` writes it"):
        _ = plain.branches
    with pytest.raises(gearatlas.AtlasError, match="there is no table `spectrum`; known tables are points, .*spectra"):
        plain.table("spectrum")


def test_numbers_of_numpy_are_numbers():
    tables = tomllib.loads(QUICKSTART.read_text())
    tables["grid"] = {"load": {"values": np.array([0.1, 0.2])}, "speed": np.float64(700.0)}
    tables["run"]["cycles"] = np.int64(3000)
    assert len(gearatlas.load(tables)) == 2


# ---- operating points


def test_points_take_values_off_the_grid():
    point = gearatlas.load(QUICKSTART).point(3, {"mesh.half_gap": "12 um"}, load=0.15, speed="9000 rpm")
    assert (point.id, point.load, point["mesh.half_gap"]) == (3, 0.15, pytest.approx(12e-6))
    assert point.speed == pytest.approx(9000 * 2 * np.pi / 60) and point.unit("speed") == "rad/s"
    with pytest.raises(gearatlas.AtlasError, match="did you mean"):
        point.changed({"mesh.half_gpa": 1.0})
    for absent in (12, -1):
        with pytest.raises(IndexError, match=f"there is no point {absent}"):
            gearatlas.load(QUICKSTART).point(absent)


# ---- runs


def test_a_run_has_the_bits_of_the_command_line(results, by_command_line):
    other = gearatlas.open(by_command_line)
    assert results.tables == other.tables == ["points", "poincare"]
    for name in results.tables:
        same_bits(results.table(name).to_pyarrow(), other.table(name).to_pyarrow())
    assert results.record["manifest_hash"] == other.record["manifest_hash"]
    assert results.record["state"] == "complete" and results.record["totals"]["points"] == 12


def test_any_number_of_threads_gives_the_same_bits(results):
    one = gearatlas.run(QUICKSTART, threads=1, progress=False)
    same_bits(one.points.to_pyarrow(), results.points.to_pyarrow())
    folder = one.folder
    assert folder.is_dir()
    del one
    assert not folder.exists(), "a temporary folder goes with its results"


def test_finished_results_are_not_computed_again(results):
    before = (results.folder / "run.json").stat().st_mtime_ns
    again = gearatlas.run(QUICKSTART, results.folder, progress=False)
    assert (results.folder / "run.json").stat().st_mtime_ns == before
    assert again.record == results.record
    with pytest.raises(gearatlas.AtlasError, match="holds results of another manifest"):
        gearatlas.run(QUICKSTART, results.folder, set={"run.cycles": 400}, progress=False)


def test_progress_is_told(tmp_path):
    told: list[gearatlas.Progress] = []
    gearatlas.run(OSCILLATOR, tmp_path / "run", progress=told.append)
    assert (told[-1].done, told[-1].points, told[-1].open) == (6, 6, False)
    assert [t.done for t in told] == sorted(t.done for t in told) and told[-1].cycles > 0


def test_progress_shows_a_bar(tmp_path, capsys):
    gearatlas.run(OSCILLATOR, tmp_path / "run")
    assert "oscillator" in (shown := capsys.readouterr().err) and "6/6" in shown


def test_what_progress_raises_ends_the_run(tmp_path):
    def refuse(progress: gearatlas.Progress) -> None:
        raise RuntimeError("enough")

    longer = {"run.cycles": 200_000, "run.settle": False, "grid.load": {"from": 0.05, "to": 0.3, "count": 40}}
    with pytest.raises(RuntimeError, match="enough"):
        gearatlas.run(OSCILLATOR, tmp_path / "run", set=longer, progress=refuse)
    assert (tmp_path / "run" / ".journal").exists()


def test_portable_instructions_are_for_a_process_of_their_own(tmp_path):
    with pytest.raises(gearatlas.AtlasError, match="atlas run"):
        gearatlas.run(OSCILLATOR, tmp_path / "run", set={"run.instructions": "portable"})


# ---- tables


def test_whoever_takes_arrow_takes_tables(results):
    points = results.points
    arrow = pa.table(points)
    frame, polar = points.to_pandas(), pl.DataFrame(points)
    counted = duckdb.sql("select count(*) from arrow where lambda_max is not null").fetchall()
    assert counted[0][0] == np.count_nonzero(~np.isnan(points["lambda_max"]))
    for name in ("load", "speed", "lambda_max", "deflection_rms"):
        np.testing.assert_array_equal(points[name], frame[name].to_numpy(float, na_value=np.nan))
        np.testing.assert_array_equal(points[name], polar[name].to_numpy())
    assert frame.attrs["units"] == points.units and points.units["speed"] == "rad/s"
    assert arrow.field("speed").metadata[b"unit"] == b"rad/s"
    assert json.loads(arrow.schema.metadata[b"units"]) == points.units
    assert isinstance(frame, pd.DataFrame) and points.descriptions["lambda_max"]


def test_nothing_is_copied_on_the_way_to_arrow(results):
    first, second = (pa.table(results.points)["speed"].chunk(0).buffers()[1].address for _ in range(2))
    assert first == second


def test_columns_are_arrays(results):
    points = results.points
    assert points["point_id"].dtype == np.uint64 and points["status"].dtype == object
    assert points["harmonics"].shape == (12, 5)
    expected = points["lambda_max"].reshape(3, 4)
    np.testing.assert_array_equal(points.on_grid("lambda_max"), expected)
    assert points.on_grid("class")[1, 2] == points["class"][6]
    assert points.to_dicts()[4]["load"] == points["load"][4]
    with pytest.raises(KeyError):
        points["lambda"]


def test_a_sweep_up_and_down_has_two_columns_over_the_grid(tmp_path):
    changes = {"grid.order": "both", "grid.load": 0.1, "run.transient": 20, "run.cycles": 60}
    points = gearatlas.run(OSCILLATOR, tmp_path / "both", set=changes, progress=False).points
    assert points.rows == 6
    with pytest.raises(ValueError, match="direction='up'"):
        points.on_grid("point_id")
    with pytest.raises(ValueError, match="no sweep has the direction"):
        points.on_grid("point_id", direction="sideways")
    for direction in ["up", "down"]:
        own = [row for row in points.to_dicts() if row["direction"] == direction]
        known = [row["point_id"] for row in sorted(own, key=lambda row: row["speed"])]
        np.testing.assert_array_equal(points.on_grid("point_id", direction).ravel(), known)


def test_units_are_read_by_pint(results):
    pint = pytest.importorskip("pint")
    quantities = {name: results.points.quantity(name) for name, unit in results.points.units.items() if unit}
    assert quantities["speed"].to("rpm").magnitude[0] == pytest.approx(6000)
    assert quantities["impact_velocity"].check("[speed]") and quantities["lambda_max"].check("[]")
    assert isinstance(quantities["force_mean"], pint.Quantity)


def test_damaged_results_are_refused(results, tmp_path):
    for path in results.folder.iterdir():
        if path.is_file():
            (tmp_path / path.name).write_bytes(path.read_bytes())
    table = tmp_path / "points.parquet"
    table.write_bytes(table.read_bytes()[:-1])
    with pytest.raises(gearatlas.AtlasError, match="is damaged"):
        gearatlas.open(tmp_path).points
    with pytest.raises(gearatlas.AtlasError, match="no results in"):
        gearatlas.open(tmp_path / "elsewhere")


# ---- single trajectories, structure, orbits


def test_a_trace_has_the_bits_of_the_command_line(tmp_path):
    point = gearatlas.load(QUICKSTART).point(load=0.2, speed=1000.0)
    traced = gearatlas.trace(point, cycles=4, skip=100, modal=True, outputs=True, tables=tmp_path)
    command = [ATLAS, "trace", QUICKSTART, "--point", "load=0.2,speed=1000", "--cycles", "4", "--skip", "100"]
    subprocess.run([*command, "--modal", "--outputs", "--out", tmp_path / "trace"], check=True, capture_output=True)
    written = gearatlas.open(tmp_path / "trace")
    same_bits(traced.samples.to_pyarrow(), written.trace.to_pyarrow())
    same_bits(traced.events.to_pyarrow(), written.events.to_pyarrow())
    assert traced.samples["displacement"].shape == (4 * 64, 12) and traced.stop is None


def test_the_structure_is_told(tmp_path):
    point = gearatlas.load(QUICKSTART).point()
    found = gearatlas.structure(point, samples=100, tables=tmp_path)
    assert found.modes.rows == found.natural.rows == 12
    assert (np.diff(found.natural["open"]) >= 0).all() and found.modes.units["frequency"] == "rad/s"
    stiffness = found.mesh["stiffness"]
    assert stiffness.shape == (100,) and stiffness.mean() == pytest.approx(4e8, rel=0.01)
    assert found.mesh["gap"] == pytest.approx(10e-6)
    assert np.abs(found.mesh["transmission_error"]).max() == pytest.approx(5e-6, rel=1e-3)
    told = subprocess.run([ATLAS, "check", QUICKSTART, "--json"], capture_output=True, text=True, check=True)
    closed = [mode["frequency_hz"] for mode in json.loads(told.stdout)["structure"]["closed"]]
    np.testing.assert_allclose(found.natural["closed"] / (2 * np.pi), closed, rtol=1e-12, atol=1e-9)

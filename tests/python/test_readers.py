"""Result files as their users read them: pandas, polars, duckdb, with units.

`sample/` and `sharded/` are written by `cargo test --test jobs store_sample`, whose `row` says
what every point holds. ATLAS_SAMPLE_RESULTS names a folder that `atlas run` wrote;
`scripts/test` provides both.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import duckdb
import numpy as np
import pandas as pd
import polars as pl
import pyarrow.dataset
import pyarrow.parquet
import pytest

ROOT = Path(__file__).resolve().parents[2]
WRITTEN = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "tmp"
SAMPLE, SHARDED = WRITTEN / "sample", WRITTEN / "sharded"

U64, U32, F64, TEXT, BOOL, LIST = "uint64", "uint32", "float64", "text", "bool", "list"
COLUMNS = {
    "point_id": U64, "load": F64, "speed": F64, "status": TEXT, "reason": TEXT, "class": TEXT,
    "period": U32, "lambda_max": F64, "lambda_stderr": F64, "lambda_twin": F64,
    "lambda_twin_stderr": F64, "twin_agrees": BOOL, "lambda_method": TEXT, "exponents": LIST,
    "exponents_stderr": LIST, "kaplan_yorke": F64, "kaplan_yorke_stderr": F64, "course_cycles": LIST, "course_exponents": LIST,
    "course_stderr": LIST, "trajectories": U32, "errors_verified": BOOL, "correlation_cycles": F64, "ess": F64, "rhat": F64,
    "rotation_number": F64, "chaos_lifetime": F64, "chaos_lifetime_low": F64, "chaos_lifetime_high": F64,
    "chaos_cycles": U64, "chaos_exits": U32, "ended_on": TEXT, "transient_lambda": F64,
    "transient_lambda_stderr": F64, "transient_deflection_rms": F64, "transient_deflection_rms_stderr": F64,
    "transient_force_std": F64, "transient_force_std_stderr": F64, "transient_impact_velocity": F64,
    "transient_impact_velocity_stderr": F64, "chain_lengths": LIST, "chain_growth": LIST,
    "events_per_cycle": F64, "attractors": U32, "horizon": F64, "horizon_stderr": F64,
    "saturation": F64, "averaging_exponent": F64, "covariant_exponents": LIST,
    "covariant_exponents_stderr": LIST, "covariant_exponents_spread": LIST, "unstable_directions": U32,
    "stable_directions": U32, "angle_min": F64, "angle_mean": F64, "angle_mean_stderr": F64, "angle_quantiles": LIST, "fraction_drive": F64,
    "fraction_drive_stderr": F64, "fraction_free": F64, "fraction_free_stderr": F64,
    "fraction_coast": F64, "fraction_coast_stderr": F64, "fraction_both": F64,
    "fraction_both_stderr": F64, "deflection_mean": F64, "deflection_mean_stderr": F64,
    "deflection_rms": F64, "deflection_rms_stderr": F64, "deflection_pp": F64,
    "deflection_peak": F64, "deflection_peak_quantiles": LIST, "deflection_peak_quantiles_stderr": LIST, "deflection_crest": F64, "deflection_kurtosis": F64,
    "deflection_kurtosis_stderr": F64, "harmonics": LIST, "harmonics_stderr": LIST, "suborders": LIST,
    "suborders_stderr": LIST, "force_mean": F64, "force_mean_stderr": F64, "force_std": F64,
    "force_std_stderr": F64, "force_peak": F64, "force_peak_quantiles": LIST, "force_peak_quantiles_stderr": LIST,
    "contact_force": LIST, "contact_force_stderr": LIST,
    "contact_fraction": LIST, "contact_fraction_stderr": LIST, "contact_impact_rate": LIST, "contact_impact_rate_stderr": LIST,
    "contact_rattle_index": LIST, "contact_rattle_index_stderr": LIST, "contact_loss": LIST, "contact_loss_stderr": LIST,
    "power_loss": F64, "power_loss_stderr": F64,
    "power_transmitted": F64, "power_transmitted_stderr": F64, "efficiency": F64, "efficiency_stderr": F64,
    "friction_coefficient": F64,
    "power_in_loads": F64, "power_in_loads_stderr": F64,
    "power_in_error": F64, "power_in_error_stderr": F64,
    "power_in_stiffness": F64, "power_in_stiffness_stderr": F64,
    "power_out_contact": F64, "power_out_contact_stderr": F64,
    "power_out_structure": F64, "power_out_structure_stderr": F64,
    "power_out_friction": F64, "power_out_friction_stderr": F64,
    "power_stored": F64, "power_stored_stderr": F64,
    "impact_rate": F64, "impact_rate_stderr": F64,
    "impacts_drive": U64, "impacts_coast": U64, "impact_velocity": F64,
    "impact_velocity_stderr": F64, "impact_power": F64, "impact_power_stderr": F64,
    "rattle_index": F64, "rattle_index_stderr": F64, "impact_velocity_quantiles": LIST,
    "impact_velocity_quantiles_stderr": LIST, "impact_velocity_max": F64, "flights": U64,
    "flight_mean": F64, "flight_mean_stderr": F64, "flight_median": F64,
    "flight_median_stderr": F64, "contacts": U64, "contact_mean": F64,
    "contact_mean_stderr": F64, "contact_median": F64, "contact_median_stderr": F64,
    "bearing_mean": LIST, "bearing_mean_stderr": LIST, "bearing_rms": LIST,
    "bearing_rms_stderr": LIST, "torque_mean": LIST, "torque_mean_stderr": LIST, "torque_rms": LIST,
    "torque_rms_stderr": LIST, "acceleration_rms": LIST, "acceleration_rms_stderr": LIST,
    "angular_acceleration_rms": LIST, "angular_acceleration_rms_stderr": LIST,
    "mesh_deflection_rms": LIST, "mesh_deflection_rms_stderr": LIST, "mesh_force_rms": LIST,
    "mesh_force_rms_stderr": LIST, "misalignment_loaded": F64, "load_centre": F64, "mesh_stiffness": F64,
    "contact_ratio_loaded": F64, "transmission_error_pp": F64, "energy_residual": F64, "grazing_count": U64, "cycles": U64,
    "measured_cycles": U64, "nvh_cycles": U64, "kernel": TEXT, "wall_time": F64, "worker": U32, "numa_node": U32,
}  # fmt: skip
POLARS = {
    U64: pl.UInt64, U32: pl.UInt32, F64: pl.Float64, TEXT: pl.String, BOOL: pl.Boolean,
    LIST: pl.List(pl.Float64),
}  # fmt: skip
DUCKDB = {
    U64: "UBIGINT", U32: "UINTEGER", F64: "DOUBLE", TEXT: "VARCHAR", BOOL: "BOOLEAN",
    LIST: "DOUBLE[]",
}  # fmt: skip
FAILED = 13


def by_id(frame: pd.DataFrame) -> pd.DataFrame:
    return frame.set_index("point_id").sort_index()


@pytest.fixture(params=[SAMPLE, SHARDED], ids=["whole", "shards"])
def results(request) -> Path:
    assert request.param.is_dir(), "run `cargo test --release --test jobs store_sample` first"
    return request.param


def test_pandas(results):
    points = pd.read_parquet(results / "points.parquet")
    assert list(points.columns) == list(COLUMNS)
    for name in ("point_id", "grazing_count", "cycles", "measured_cycles"):
        assert points[name].dtype == np.uint64, name
    for name, kind in COLUMNS.items():
        if kind == F64:
            assert points[name].dtype == np.float64, name
    points = by_id(points)
    assert list(points.index) == list(range(80))
    assert points.loc[12, "lambda_max"] == pytest.approx(0.22, rel=1e-15)
    assert points.loc[12, "class"] == "chaotic"
    assert points.loc[14, "period"] == 2
    assert list(points.loc[12, "harmonics"]) == [1e-6, 2e-6, 3e-6]


def test_polars(results):
    points = pl.read_parquet(results / "points.parquet").sort("point_id")
    assert points.schema == {name: POLARS[kind] for name, kind in COLUMNS.items()}
    assert points["point_id"].to_list() == list(range(80))
    assert points["exponents"][12].to_list() == pytest.approx([0.22, -1.0], rel=1e-15)
    assert points["exponents_stderr"][12].to_list() == [0.01, 0.02]
    assert points["kaplan_yorke"][12] == pytest.approx(1.22, rel=1e-15)
    assert points["course_cycles"][12].to_list() == [320, 640]
    assert points["course_exponents"][12].to_list() == pytest.approx([0.22, 0.23, -1.0, -1.01], rel=1e-15)
    assert points["course_stderr"][12].to_list() == [0.02, 0.01, 0.02, 0.01]
    chaotic = points.filter(pl.col("class") == "chaotic")
    assert chaotic["point_id"].to_list() == list(range(0, 80, 3))


def test_duckdb(results):
    points = f"'{results / 'points.parquet'}'"
    described = duckdb.sql(f"describe select * from {points}").fetchall()
    assert {row[0]: row[1] for row in described} == {n: DUCKDB[k] for n, k in COLUMNS.items()}
    counted = duckdb.sql(f"select class, count(*) from {points} group by class").fetchall()
    assert dict(counted) == {"chaotic": 27, "periodic": 52, None: 1}
    joined = duckdb.sql(
        f"""select count(*) from {points} join '{results / "poincare.parquet"}' using (point_id)
            where deflection = deflection_rms"""
    ).fetchall()
    assert joined == [(79,)], "every sample joins its own point"


def test_absent_values_are_nulls_never_nan(results):
    points = pl.read_parquet(results / "points.parquet").sort("point_id")
    for name, kind in COLUMNS.items():
        if kind == F64:
            assert not points[name].is_nan().any(), name
    names = list(COLUMNS)
    for name in names[names.index("class") : names.index("energy_residual") + 1]:
        assert points[name][FAILED] is None, name
    assert points["status"][FAILED] == "failed"
    assert points["reason"].null_count() == 0
    assert points["numa_node"].null_count() == 80
    assert points["lambda_twin"].null_count() == 80 - 27


def test_units(results):
    schema = pyarrow.dataset.dataset(results / "points.parquet").schema
    units = json.loads(schema.metadata[b"units"])
    descriptions = json.loads(schema.metadata[b"descriptions"])
    assert json.loads(schema.metadata[b"axes"]) == ["load", "speed"]
    assert set(units) == set(descriptions) == set(COLUMNS)
    expected = {
        "speed": "rad/s", "load": "1", "lambda_max": "1/cycle", "deflection_rms": "m",
        "harmonics": "m", "force_peak": "N", "impact_rate": "1/s", "impact_velocity": "m/s",
        "wall_time": "s", "cycles": "mesh cycles", "status": "",
    }  # fmt: skip
    assert expected.items() <= units.items()
    for name in COLUMNS:
        assert schema.field(name).metadata[b"unit"].decode() == units[name]
        assert schema.field(name).metadata[b"description"].decode() == descriptions[name]
    # The same from readers that know nothing of Arrow metadata.
    part = next(iter(pyarrow.dataset.dataset(results / "points.parquet").files))
    assert json.loads(pl.read_parquet_metadata(part)["units"]) == units
    pairs = duckdb.sql(f"select key, value from parquet_kv_metadata('{part}')").fetchall()
    assert json.loads(dict(pairs)[b"units"]) == units


def test_orders(results):
    orders = pl.read_parquet(results / "orders.parquet").sort("point_id")
    assert orders.height == 79
    assert set(orders["signal"]) == {"bearing pinion 1 x"}
    assert orders["amplitude"].to_list() == [float(i) for i in range(80) if i != FAILED]
    assert orders["amplitude_stderr"].null_count() == orders["phase_stderr"].null_count() == 52
    units = json.loads(pl.read_parquet_metadata(results_part(results / "orders.parquet"))["units"])
    assert units["phase"] == "rad" and orders["unit"][0] == "N"


def results_part(table: Path) -> Path:
    """A file of a table, which is a folder where a run was split."""
    return next(iter(sorted(table.glob("*.parquet")))) if table.is_dir() else table


def test_probes(results):
    points = pd.read_parquet(results / "points.parquet")
    probes = pd.read_parquet(results / "probes.parquet")
    assert len(probes) == 4 * 79
    assert sorted(probes["point_id"].unique()) == [n for n in range(80) if n != FAILED]
    # Attractors are numbered from 0 without a gap; probes on none are nulls, still counted.
    settled = probes.dropna(subset="attractor_id")
    assert len(probes) - len(settled) == 79
    found = settled.groupby("point_id")["attractor_id"].nunique()
    assert (by_id(points)["attractors"].dropna() == found).all()
    assert (settled.groupby("point_id")["attractor_id"].max() == found - 1).all()
    shares = probes.assign(ending=probes["attractor_id"].astype(object).fillna("none"))
    once = shares.drop_duplicates(["point_id", "ending"]).groupby("point_id")["basin_share"].sum()
    assert np.allclose(once, 1.0)
    assert (probes["basin_low"] < probes["basin_share"]).all()
    assert (probes["basin_share"] < probes["basin_high"]).all()
    polars = pl.read_parquet(results / "probes.parquet")
    assert polars.schema["attractor_id"] == pl.UInt32
    assert polars.schema["amplitude"] == pl.Float64
    joined = duckdb.sql(
        f"""select count(*) from '{results / "points.parquet"}' as p
            join '{results / "probes.parquet"}' as q using (point_id)
            where q.probe_id = 0 and p.attractors = 2"""
    ).fetchall()
    assert joined == [(40,)]
    metadata = pyarrow.dataset.dataset(results / "probes.parquet").schema.metadata
    units = json.loads(metadata[b"units"])
    assert units["amplitude"] == "half gaps" and units["lambda"] == "1/cycle"


def test_followed_orbits():
    folder = WRITTEN / "followed"
    assert folder.is_dir(), "run `cargo test --release --test motion followed` first"
    names = ("branches", "bifurcations", "curves")
    branches, bifurcations, curves = (pd.read_parquet(folder / f"{n}.parquet") for n in names)
    for name, frame in zip(names, (branches, bifurcations, curves)):
        metadata = pyarrow.parquet.read_schema(folder / f"{name}.parquet").metadata
        units = json.loads(metadata[b"units"])
        assert set(units) == set(json.loads(metadata[b"descriptions"])) == set(frame.columns)
        assert json.loads(metadata[b"axes"]) == ["load", "speed"]
        assert (metadata[b"over"], metadata[b"second"]) == (b"speed", b"load")
        assert units["speed"] == "rad/s" and units["deflection_rms"] == "m"
        schema = pl.read_parquet(folder / f"{name}.parquet").schema
        assert schema["period"] == pl.UInt32 and schema["stable"] == pl.Boolean
    # Orbits are counted along their branch; a stable one has all multipliers inside the circle.
    assert (branches.groupby("branch").cumcount() == branches["index"]).all()
    assert branches.groupby("branch")["length"].is_monotonic_increasing.all()
    size = np.hypot(branches["multiplier_re"], branches["multiplier_im"])
    assert ((size < 1) == branches["stable"]).all()
    assert np.allclose(np.log(size) / branches["period"], branches["lambda"])
    # Every bifurcation lies in its bracket, behind the orbit that it names; every branch ends twice.
    ends = bifurcations[bifurcations["kind"] == "end"]
    assert (ends.groupby("branch").size() == 2).all()
    assert set(ends["branch"]) == set(branches["branch"])
    found = bifurcations[bifurcations["kind"] != "end"]
    room = 1e-9 * found["speed"]
    assert (found["low"] <= found["speed"] + room).all()
    assert (found["speed"] <= found["high"] + room).all()
    before = found.merge(branches, left_on=["branch", "after"], right_on=["branch", "index"])
    assert len(before) == len(found) and (before["load_x"] == before["load_y"]).all()
    # On a curve of doublings a multiplier is -1; an onset is no orbit.
    doublings = found[found["kind"] == "period_doubling"]
    assert len(doublings) and np.allclose(doublings["critical_re"], -1.0, atol=1e-6)
    onset = curves[curves["kind"] == "onset"]
    assert len(onset) and onset["period"].isna().all()
    assert curves[curves["kind"] != "onset"]["period"].notna().all()
    joined = duckdb.sql(
        f"""select count(*) from '{folder / "branches.parquet"}' as b
            join '{folder / "bifurcations.parquet"}' as f
            on f.branch = b.branch and f.after = b.index where f.kind = 'end'"""
    ).fetchall()
    assert joined == [(2 * branches["branch"].nunique(),)]


def test_orbits(results):
    orbits = pd.read_parquet(results / "orbits.parquet")
    assert len(orbits) == 2 * 79
    found, missed = orbits[orbits["found"]], orbits[~orbits["found"]]
    assert len(found) == 79 and found["reason"].isna().all() and found["state"].isna().all()
    assert (found["stable"].astype(bool) == (found["point_id"] % 2 == 0)).all()
    leading = found["multipliers_re"].str[0]
    assert np.allclose(np.log(leading.abs()) / found["period"], found["lambda"])
    assert np.allclose(found["kick_distance"].str[1] / found["kick_distance"].str[0], 3.0)
    assert np.allclose(found["kick_distance_linear"].str[1], 2e-5)
    assert (found["displacement"].str.len() == 1).all()
    # A given state that led to no orbit says why; all that describes an orbit is null.
    assert (missed["reason"] == "as designed").all() and (missed["state"] == 1).all()
    assert missed[["stable", "lambda", "kick_distance", "displacement"]].isna().all(axis=None)
    polars = pl.read_parquet(results / "orbits.parquet").filter(pl.col("found"))
    assert polars["kick_distance"].list.len().to_list() == [2] * 79
    flips = f"select count(*) from '{results / 'orbits.parquet'}' where bifurcation = 'flip'"
    assert duckdb.sql(flips).fetchall() == [(39,)]
    units = json.loads(pyarrow.dataset.dataset(results / "orbits.parquet").schema.metadata[b"units"])
    assert units["kick_distance"] == "half gaps" and units["modal_velocity"] == "m sqrt(kg)/s"


def test_shards_hold_the_same_points():
    whole, sharded = (by_id(pd.read_parquet(f / "points.parquet")) for f in (SAMPLE, SHARDED))
    pd.testing.assert_frame_equal(whole, sharded)


def test_example_script(results, tmp_path):
    script, picture = ROOT / "examples" / "read_results.py", tmp_path / "lambda.png"
    done = subprocess.run(
        [sys.executable, script, results, "--plot", picture],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert "speed [rad/s]" in done.stdout and "λ [1/cycle]" in done.stdout
    assert "0.22" in done.stdout
    assert picture.read_bytes().startswith(b"\x89PNG") and picture.stat().st_size > 10_000


@pytest.fixture
def run() -> Path:
    folder = os.environ.get("ATLAS_SAMPLE_RESULTS")
    if folder is None:
        pytest.skip("ATLAS_SAMPLE_RESULTS is not set (scripts/test sets it)")
    return Path(folder)


def test_results_of_a_run(run):
    record = json.loads((run / "run.json").read_text())
    assert record["state"] == "complete"
    assert "[job]" in record["manifest"] and record["manifest_hash"]
    points = pl.read_parquet(run / "points.parquet")
    assert points["point_id"].to_list() == list(range(record["totals"]["points"]))
    assert points["cycles"].sum() == record["totals"]["cycles"]
    assert (points["status"] == "ok").sum() == record["totals"]["ok"]
    metadata = pyarrow.parquet.read_schema(run / "points.parquet").metadata
    units, axes = (json.loads(metadata[key]) for key in (b"units", b"axes"))
    assert set(units) == set(points.columns)
    assert points.columns[1 : 1 + len(axes)] == axes
    assert len(points.select(axes).unique()) == len(points)
    for name in points.columns:
        if points[name].dtype == pl.Float64:
            assert not points[name].is_nan().any(), name


def test_lambda_has_an_error_bar(run):
    points = pl.read_parquet(run / "points.parquet")
    found = points.filter(pl.col("lambda_max").is_not_null())
    assert found["lambda_stderr"].null_count() == 0
    chaotic = found.filter(pl.col("class") == "chaotic")
    assert (chaotic["lambda_max"] > chaotic["lambda_stderr"]).all()
    first = found["exponents"].list.first()
    assert (first == found["lambda_max"]).all()

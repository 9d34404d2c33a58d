"""Followed orbits in Python: `gearatlas.follow` on an oscillator against a gap, and beside it the command line."""

import subprocess

import numpy as np
import pyarrow as pa
import pytest

import gearatlas
from program import ATLAS, ROOT, same_bits

HEAD = (ROOT / "tests/manifests/oscillator.head.toml").read_text()
MANIFEST = HEAD.replace('file = "', f'file = "{ROOT}/tests/manifests/') + """
transient = 300
[analyses]
lyapunov = { exponents = 1, effort = "survey" }
nvh = { harmonics = 3 }
[grid]
speed = { from = 600, to = 1500, count = 10 }
load = { values = [0.05, 0.1] }
[continuation]
over = "speed"
second = "load"
starts = 8
longest_period = 2
"""

TABLES = ["branches", "bifurcations", "curves"]


@pytest.fixture(scope="module")
def told() -> list[str]:
    return []


@pytest.fixture(scope="module")
def followed(tmp_path_factory, told) -> gearatlas.Results:
    return gearatlas.follow(MANIFEST, tmp_path_factory.mktemp("out") / "case", threads=2, progress=told.append)


def test_the_tables_have_the_bits_of_the_command_line(followed, tmp_path):
    (tmp_path / "case.toml").write_text(MANIFEST)
    command = [ATLAS, "follow", tmp_path / "case.toml", "--threads", "1", "--out", tmp_path / "out"]
    subprocess.run(command, check=True, capture_output=True, cwd=tmp_path)
    theirs = gearatlas.open(tmp_path / "out")
    assert followed.tables == theirs.tables == TABLES
    for name in TABLES:
        same_bits(followed.table(name).to_pyarrow(), theirs.table(name).to_pyarrow())


def test_branches_meet_their_special_points(followed, told):
    branches, special = followed.branches, followed.bifurcations
    assert branches.rows > 50 and set(np.unique(branches["period"])) <= {1, 2}
    assert {"graze", "fold"} & set(special["kind"]) and branches.units["speed"] == "rad/s"
    # What changes stability lies between the orbit before it and the next one.
    orbits = {(row["branch"], row["index"]): row for row in branches.to_dicts()}
    found = 0
    for row in special.to_dicts():
        before, after = (orbits.get((row["branch"], row["after"] + step)) for step in (0, 1))
        if row["kind"] == "fold" and before and after:
            found += 1
            assert before["unstable"] != after["unstable"]
            assert row["critical_re"] == pytest.approx(1.0, abs=1e-3)
    assert found >= 1
    # Stable orbits have multipliers inside the unit circle.
    moduli = np.hypot(branches["multiplier_re"], branches["multiplier_im"])
    np.testing.assert_array_equal(moduli < 1.0, branches["stable"].astype(bool))
    assert len(told) >= 2


def test_curves_pass_through_what_they_continue(followed):
    curves, special = followed.curves, followed.bifurcations
    folds = [row for row in special.to_dicts() if row["kind"] == "fold"]
    assert folds
    for fold in folds:
        near = (curves["kind"] == "fold") & (np.abs(curves["load"] - fold["load"]) < 0.02)
        assert np.abs(curves["speed"][near] - fold["speed"]).min() < 0.02 * fold["speed"]


def test_arrow_takes_followed_tables(followed):
    for name in TABLES:
        table = followed.table(name)
        assert pa.table(table).num_rows == table.rows > 0


def test_a_manifest_that_follows_nothing_is_refused(tmp_path):
    with pytest.raises(gearatlas.AtlasError, match="continuation"):
        gearatlas.follow(MANIFEST.split("[continuation]")[0], tmp_path / "none")

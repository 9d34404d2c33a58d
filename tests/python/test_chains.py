"""Effective sample size and R-hat of a row, by ArviZ from the chains that the row holds."""

import subprocess

import numpy as np
import polars as pl
import pytest

from program import ATLAS, ROOT


def test_arviz_gives_the_same_figures(tmp_path):
    # Each process that imports ArviZ for the first time of a day writes a file. Here only the process of this test does.
    import arviz

    out = tmp_path / "run"
    command = [
        ATLAS, "run", ROOT / "tests/manifests/oscillator.toml", "--out", out, "--quiet",
        "--set", "analyses.lyapunov={chains=true, twin=false}", "--set", "run.cycles=40000",
    ]
    assert subprocess.run([str(part) for part in command]).returncode == 0
    row = pl.read_parquet(out / "points.parquet").row(0, named=True)
    lengths = [int(length) for length in row["chain_lengths"]]
    growth = np.array(row["chain_growth"])
    assert len(lengths) == row["trajectories"] == 8 and sum(lengths) == len(growth)
    chains = np.split(growth, np.cumsum(lengths)[:-1])
    # Chains of equal length, as ArviZ takes them.
    shortest = min(lengths)
    chains = np.array([chain[:shortest] for chain in chains])
    assert row["rhat"] == pytest.approx(float(arviz.rhat(chains, method="split")), rel=1e-9)
    assert row["ess"] == pytest.approx(float(arviz.ess(chains, method="mean")), rel=1e-9)
    assert row["lambda_max"] == pytest.approx(growth.mean(), rel=1e-12)
    assert row["correlation_cycles"] < row["measured_cycles"] / 20

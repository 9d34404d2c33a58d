"""What do the gearbox's map, 400 speeds of helical gears and 10 000 sampled drives cost? How much does the gearbox's film of oil
change? How probable is rattle?

    scripts/record flagship

The probability from Sobol' points of manifests/tolerances.toml stands beside a count of drives whose four quantities come from
independent random numbers of NumPy instead.
"""

import pathlib
import re
import statistics
import sys
import tempfile

import numpy as np
import polars as pl
from record_before_after import SPEEDS
from records import ATLAS, ROOT, keep, percent, processor_time, table, this_run
from scipy.stats import binomtest

SAMPLES = 10_000
COUNTED = 4000
RPM = (6000, 9000)
TOLERANCES = ROOT / "manifests/tolerances.toml"


def run(work: pathlib.Path, name: str, manifest: pathlib.Path, *arguments: str) -> tuple[float, pl.DataFrame]:
    """Processor time of a run on one thread [s], and its points."""
    out = work / name
    command = [ATLAS, "run", manifest, "--out", out, "--tables", work / "tables", "--threads", "1", "--quiet", "--overwrite", *arguments]
    return processor_time(command, cwd=ROOT), pl.read_parquet(out / "points.parquet")


def independent(work: pathlib.Path, rpm: int) -> pathlib.Path:
    """The drives of the manifest with independent random numbers, as a list of points."""
    random = np.random.default_rng(rpm)
    gap = random.normal(80, 10, 2 * COUNTED)
    rows = np.column_stack([
        gap[(gap >= 40) & (gap <= 120)][:COUNTED],
        random.uniform(0.03, 0.07, COUNTED),
        3 * np.exp(0.3 * random.standard_normal(COUNTED)),
        5 * np.exp(0.4 * random.standard_normal(COUNTED)),
    ])
    keys = "mesh.half_gap [um],mesh.contact_damping,excitation.transmission_error.0.amplitude [um],excitation.gear_error.0.amplitude [um]"
    lines = [f"speed [rpm],load,{keys}", *(f"{rpm},0.5," + ",".join(f"{value:.12g}" for value in row) for row in rows)]
    (work / "points.csv").write_text("\n".join(lines) + "\n")
    text = re.sub(r"\n\[grid\].*?(?=\n\[)", '\n[grid]\npoints = "points.csv"\n', TOLERANCES.read_text(), flags=re.S)
    (work / "independent.toml").write_text(text)
    return work / "independent.toml"


def probability(points: pl.DataFrame) -> dict:
    """Share of drives whose mesh loses contact, with the interval of Clopper and Pearson."""
    count = int((points["fraction_free"] > 0).sum())
    low, high = binomtest(count, len(points)).proportion_ci(method="exact")
    return {"share": count / len(points), "low": low, "high": high, "drives": len(points)}


def without_film(work: pathlib.Path) -> pathlib.Path:
    """The gearbox without oil between its flanks."""
    text, count = re.subn(r"\nfilm = .*", "", (ROOT / "manifests/gearbox.toml").read_text())
    assert count == 1
    (work / "dry.toml").write_text(text)
    return work / "dry.toml"


def main(folder: str) -> None:
    rows, rattle = {}, []
    with tempfile.TemporaryDirectory() as name:
        work = pathlib.Path(name)
        for words in ("without kept tables", "with kept tables"):
            seconds, points = run(work, "gearbox", ROOT / "manifests/gearbox.toml")
            exact = points["force_mean_stderr"].null_count()
            rows[f"`gearbox.toml`, {len(points)} points, {exact} of them periodic and without error bars, {words}"] = seconds
        seconds, dry = run(work, "dry", without_film(work))
        rows["the same without a film of oil"] = seconds
        both = points.join(dry, on=["load", "speed"], suffix="_dry").filter((pl.col("rattle_index") > 0) & (pl.col("rattle_index_dry") > 0))
        film = {name: (both[name] / both[f"{name}_dry"]).to_list() for name in ("rattle_index", "impact_velocity", "force_peak")}
        for words in ("without kept tables", "with kept tables"):
            seconds, points = run(work, "speeds", ROOT / "manifests/flex80.toml", *SPEEDS[2:])
            steady = (points["class"] == "steady_contact").sum()
            rows[f"{len(points)} speeds of helical gears, 12 modes, {steady} of them in steady contact, {words}"] = seconds
        for rpm in RPM:
            speed = ["--set", f'grid.speed="{rpm} rpm"']
            seconds, many = run(work, "many", TOLERANCES, *speed, "--set", f"grid.samples={SAMPLES}")
            rows[f"{SAMPLES} drives of `tolerances.toml` at {rpm} rpm, 12 modes"] = seconds
            _, few = run(work, "few", TOLERANCES, *speed)
            _, counted = run(work, "counted", independent(work, rpm))
            rattle.append({"rpm": rpm, "few": probability(few), "many": probability(many), "counted": probability(counted)})
    about = this_run()
    lines = [
        f"# {pathlib.Path(folder).name}\n",
        f"`scripts/record flagship` on {about['cpu']}, load average {about['load']} at the end; commit {about['commit'][:8]}. Processor time, "
        "user and system, on one thread. Tables are those of the mesh from the drawing.\n",
        *table(["job", "time [s]"], [(words, f"{seconds:.1f}") for words, seconds in rows.items()]),
        f"The film of oil of `gearbox.toml`, at the {len(both)} points that rattle with and without it:\n",
        *table(
            ["statistic", "with film / without: median", "smallest", "largest"],
            [(name, *(f"{pick(ratios):.2f}" for pick in (statistics.median, min, max))) for name, ratios in film.items()],
        ),
        "Probability that the teeth part [%], with 95 % intervals:\n",
        *table(
            ["speed [rpm]", *(f"{rattle[0][kind]['drives']} {words}" for kind, words in COLUMNS.items())],
            [(row["rpm"], *(percent(row[kind]) for kind in COLUMNS)) for row in rattle],
        ),
    ]
    keep(folder, lines, record={**about, "seconds": rows, "film": film, "rattle": rattle})


COLUMNS = {"few": "samples", "many": "samples", "counted": "independent drives"}


if __name__ == "__main__":
    main(*sys.argv[1:])

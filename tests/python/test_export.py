"""What `atlas export` and `python -m gearatlas.export` write, read back by the programs that it is for, has the values of the tables.

`cargo test --release --test jobs --test pictures` leaves the folders that are exported in
target/tmp, and says in target/tmp/exported/atlas where the program is."""

import json
import os
import subprocess
import sys
from pathlib import Path

import gearatlas
import numpy as np
import openpyxl
import pandas as pd
import pyarrow as pa
import pyarrow.dataset
import pytest
import scipy.io

ROOT = Path(__file__).resolve().parents[2]
WRITTEN = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "tmp"
FOLDERS = ["sample", "sharded", "exported/trace"]


@pytest.fixture(scope="module", params=FOLDERS)
def source(request) -> Path:
    folder = WRITTEN / request.param
    assert folder.is_dir(), "run `cargo test --release --test jobs --test pictures` first"
    return folder


def export(source: Path, out: Path, *options: str) -> Path:
    program = (WRITTEN / "exported" / "atlas").read_text()
    subprocess.run([program, "export", source, "--quiet", "--out", out, *options], check=True)
    return out


def package_export(source: Path, out: Path, format: str, *options: str) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "gearatlas.export", source, "--format", format, "--out", out, *options]
    return subprocess.run(command, capture_output=True, text=True, cwd=out)


def tables(source: Path) -> dict[str, pa.Table]:
    paths = sorted(source.glob("*.parquet"))
    assert paths
    # Files of shards in the order of their names.
    return {path.stem: pyarrow.dataset.dataset(path).to_table() for path in paths}


def package_tables(source: Path) -> dict[str, pa.Table]:
    """As the package reads them: rows of shards in the order of their points."""
    results = gearatlas.open(source)
    return {name: pa.table(results.table(name)) for name in results.tables}


def unit(field: pa.Field) -> str:
    return field.metadata[b"unit"].decode()


def width(column: pa.ChunkedArray) -> int:
    return max((len(each) for each in column.to_pylist() if each is not None), default=0)


def matrix(column: pa.ChunkedArray) -> np.ndarray:
    """Lists as rows, NaN behind their end."""
    rows = np.full((len(column), width(column)), np.nan)
    for row, each in zip(rows, column.to_pylist()):
        values = [np.nan if value is None else value for value in each or []]
        row[: len(values)] = values
    return rows


def numbers(column: pa.ChunkedArray) -> np.ndarray:
    return np.array([np.nan if v is None else float(v) for v in column.to_pylist()], dtype=float)


def title(field: pa.Field, suffix: str = "") -> str:
    named = field.name + suffix
    return named if unit(field) in ("", "1") else f"{named} [{unit(field)}]"


def elements(field: pa.Field) -> list[str]:
    return json.loads((field.metadata or {}).get(b"elements", b"[]"))


def suffix(field: pa.Field, place: int) -> str:
    names = elements(field)
    return names[place].replace(" ", "_") if names else str(place + 1)


def flat(table: pa.Table) -> dict[str, list]:
    """Columns by title, lists widened."""
    columns = {}
    for field in table.schema:
        column = table[field.name]
        if pa.types.is_list(field.type):
            for place in range(width(column)):
                values = [
                    each[place] if each is not None and place < len(each) else None
                    for each in column.to_pylist()
                ]
                columns[title(field, f"_{suffix(field, place)}")] = values
        else:
            columns[title(field)] = column.to_pylist()
    return columns


def test_csv(source, tmp_path):
    export(source, tmp_path, "--format", "csv")
    for name, table in tables(source).items():
        frame = pd.read_csv(
            tmp_path / f"{name}.csv", keep_default_na=False, na_values=[""],
            dtype_backend="pyarrow",
        )  # fmt: skip
        expected = flat(table)
        assert list(frame.columns) == list(expected)
        assert len(frame) == table.num_rows
        for column, values in expected.items():
            found = [None if pd.isna(value) else value for value in frame[column].tolist()]
            assert found == values, f"{name}: {column}"


def test_csv_with_lists_apart(source, tmp_path):
    export(source, tmp_path, "--lists", "long")
    for name, table in tables(source).items():
        lists = [field for field in table.schema if pa.types.is_list(field.type)]
        frame = pd.read_csv(tmp_path / f"{name}.csv")
        assert len(frame.columns) == len(table.schema) - len(lists)
        path = tmp_path / f"{name}_lists.csv"
        assert path.exists() == bool(lists)
        if not lists:
            continue
        long = pd.read_csv(path)
        for field in lists:
            found = np.full_like(matrix(table[field.name]), np.nan)
            own = long[long["column"] == field.name]
            found[own["row"] - 1, own["element"] - 1] = own["value"]
            np.testing.assert_array_equal(found, matrix(table[field.name]))
            assert set(own["unit"].dropna().astype(str)) <= {unit(field)}
            named = [elements(field)[place - 1] for place in own["element"]] if elements(field) else []
            assert own["name"].dropna().tolist() == named
        if "point_id" in table.column_names:
            ids = np.array(table["point_id"].to_pylist())
            assert (ids[long["row"] - 1] == long["point_id"]).all()


def test_npz(source, tmp_path):
    assert package_export(source, tmp_path, "npz").returncode == 0
    for name, table in package_tables(source).items():
        with np.load(tmp_path / f"{name}.npz", allow_pickle=False) as arrays:
            assert list(arrays["column_names"]) == table.column_names
            assert list(arrays["column_units"]) == [unit(field) for field in table.schema]
            named = [field for field in table.schema if elements(field)]
            assert len(arrays.files) == len(table.schema) + 3 + len(named)
            for field in named:
                assert arrays[f"{field.name}_elements"].tolist() == elements(field)
            for field in table.schema:
                found, column = arrays[field.name], table[field.name]
                if pa.types.is_list(field.type):
                    np.testing.assert_array_equal(found, matrix(column))
                elif pa.types.is_string(field.type):
                    assert found.tolist() == [text or "" for text in column.to_pylist()]
                elif pa.types.is_floating(field.type) or column.null_count:
                    assert found.dtype == np.float64
                    np.testing.assert_array_equal(found, numbers(column))
                else:
                    wanted = np.bool_ if pa.types.is_boolean(field.type) else np.uint64
                    assert found.dtype == wanted
                    assert found.tolist() == column.to_pylist()


def test_mat(source, tmp_path):
    assert package_export(source, tmp_path, "mat").returncode == 0
    (path,) = tmp_path.iterdir()
    assert path.name == f"{source.name}.mat"
    kept = scipy.io.loadmat(path, simplify_cells=True)
    raw = scipy.io.loadmat(path)
    variables = {name: shape for name, shape, _ in scipy.io.whosmat(path)}
    assert set(variables) == set(package_tables(source)) | {"units", "descriptions", "elements"}
    for name, table in package_tables(source).items():
        for field in table.schema:
            column = table[field.name]
            found = np.asarray(kept[name][field.name])
            assert raw[name][field.name][0, 0].shape[0] == table.num_rows
            if pa.types.is_list(field.type):
                np.testing.assert_array_equal(found.reshape(len(column), -1), matrix(column))
            elif pa.types.is_string(field.type):
                texts = [str(text) if np.size(text) else "" for text in found.tolist()]
                assert texts == [text or "" for text in column.to_pylist()]
            else:
                np.testing.assert_array_equal(found.astype(float), numbers(column))
                logical = pa.types.is_boolean(field.type) and not column.null_count
                assert raw[name][field.name][0, 0].dtype == (np.uint8 if logical else float)
            told = kept["units"][name][field.name]
            assert (str(told) if np.size(told) else "") == unit(field)
            told = kept["elements"][name][field.name]
            assert np.atleast_1d(told).tolist() == elements(field)


def test_xlsx(source, tmp_path):
    assert package_export(source, tmp_path, "xlsx").returncode == 0
    (path,) = tmp_path.iterdir()
    book = openpyxl.load_workbook(path)
    found = package_tables(source)
    assert set(book.sheetnames) == set(found) | {"columns"}
    for name, table in found.items():
        rows = list(book[name].iter_rows(values_only=True))
        expected = flat(table)
        assert list(rows[0]) == list(expected)
        assert len(rows) == 1 + table.num_rows
        for place, (column, values) in enumerate(expected.items()):
            # A worksheet has sixteen digits of a number.
            wanted = [pytest.approx(v, rel=1e-15, abs=0) if isinstance(v, float) else v for v in values]
            assert [row[place] for row in rows[1:]] == wanted, f"{name}: {column}"
    told = list(book["columns"].iter_rows(values_only=True))[1:]
    assert len(told) == sum(len(table.schema) for table in found.values())
    assert ("deflection", "m") in {(column, of) for _, column, of, _ in told}


def test_arrow_files_are_the_tables(source, tmp_path):
    export(source, tmp_path, "--format", "arrow")
    expected = tables(source)
    assert {path.stem for path in tmp_path.iterdir()} == set(expected)
    for name, table in expected.items():
        with pa.memory_map(str(tmp_path / f"{name}.arrow")) as file:
            read = pa.ipc.open_file(file).read_all()
        assert read.schema.names == table.schema.names and read.schema.metadata == table.schema.metadata
        for field in table.schema:
            assert read[field.name].combine_chunks().equals(table[field.name].combine_chunks()), field.name
            assert unit(read.schema.field(field.name)) == unit(field)


def test_arrow_files_have_the_columns_chosen(tmp_path):
    export(WRITTEN / "sample", tmp_path, "--format", "arrow", "--tables", "points", "--columns", "speed,lambda_max")
    read = pa.ipc.open_file(tmp_path / "points.arrow").read_all()
    assert read.schema.names == ["speed", "lambda_max"]
    assert json.loads(read.schema.metadata[b"units"])["speed"] == "rad/s"


def test_the_package_refuses_what_it_cannot_write(tmp_path):
    sample = WRITTEN / "sample"
    refused = package_export(sample, tmp_path, "npz", "--tables", "nothing")
    assert refused.returncode == 1 and "has no table `nothing`; it has " in refused.stderr
    refused = package_export(sample, tmp_path, "npz", "--columns", "nothing")
    assert refused.returncode == 1 and "no column `nothing` in " in refused.stderr
    assert list(tmp_path.iterdir()) == []
    chosen = ("--tables", "points", "--columns", "speed")
    assert package_export(sample, tmp_path, "npz", *chosen).returncode == 0
    refused = package_export(sample, tmp_path, "npz", *chosen)
    assert refused.returncode == 1 and "already exists" in refused.stderr
    assert package_export(sample, tmp_path, "npz", *chosen, "--overwrite").returncode == 0

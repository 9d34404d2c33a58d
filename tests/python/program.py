"""The program as it was built, and whether two of its tables are the same."""

import os
from pathlib import Path

import pyarrow as pa

ROOT = Path(__file__).resolve().parents[2]
ATLAS = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "atlas"
# Where and how long, not what.
PLACEMENT = {"wall_time", "worker", "numa_node"}


def same_bits(one: pa.Table, other: pa.Table) -> None:
    assert one.schema.names == other.schema.names and one.num_rows > 0
    for name in set(one.schema.names) - PLACEMENT:
        assert one[name].equals(other[name]), name

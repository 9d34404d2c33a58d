"""The program as it was built, the environment that it starts in, and whether two of its tables are the same."""

import os
from pathlib import Path

import pyarrow as pa

ROOT = Path(__file__).resolve().parents[2]
ATLAS = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "atlas"
# Where and how long, not what.
PLACEMENT = {"wall_time", "worker", "numa_node"}
# Beginnings of the names of variables that choose instructions, or the emulated processor, in place of what
# a process finds. tests/common/processor.rs has the same list.
CHOOSE_INSTRUCTIONS = (
    "ARROW_", "ATEN_CPU_", "BLIS_", "DNNL_", "GLIBC_TUNABLES", "GOTO_", "LD_HWCAP_MASK", "MKL_", "NPY_", "NVPL_",
    "ONEDNN_", "OPENBLAS_", "POLARS_SKIP_CPU_CHECK", "QEMU_",
)


def environment_without_instructions() -> dict[str, str]:
    """The environment without what chooses instructions: for processes that are to find them on their processor."""
    return {name: value for name, value in os.environ.items() if not name.startswith(CHOOSE_INSTRUCTIONS)}


def same_bits(one: pa.Table, other: pa.Table) -> None:
    assert one.schema.names == other.schema.names and one.num_rows > 0
    for name in set(one.schema.names) - PLACEMENT:
        assert one[name].equals(other[name]), name

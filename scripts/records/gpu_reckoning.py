#!/usr/bin/env python3
"""Writes the table of docs/gpu.md: operations and bytes of a mesh cycle from the record `machine` under benches/runs/,
divided by published peaks.

    .venv/bin/python scripts/records/gpu_reckoning.py           rewrites the table
    .venv/bin/python scripts/records/gpu_reckoning.py --check   status 1 if the page differs
"""

import sys

from records import link, load, write_blocks
from replication import significant

# Double precision without matrix units [operations/s], memory [bytes/s], from data sheets.
CARDS = {
    "NVIDIA H100 SXM": (34e12, 3.35e12),
    "NVIDIA A100 SXM, 80 GB": (9.7e12, 2.04e12),
    "NVIDIA GeForce RTX 4090": (1.29e12, 1.01e12),
}

# Trajectories that share one window's reads of its tables.
TOGETHER = 32


def lines() -> list[str]:
    machine = load("machine", "machine.json")
    found = [
        f"The counts are from {link('machine')}, on cores of {machine['description']['cpu']}. The columns of cores assume that cores do not wait for one another's memory.",
        "",
        "| modes | operations a cycle | bytes read | different bytes | one core, cycles/s | of its peak | card | by arithmetic, cores | by memory, alone, cores | "
        f"by memory, {TOGETHER} together, cores |",
        "|---" * 10 + "|",
    ]
    peak = max(a["figure"]["value"] for a in machine["arithmetic"] if a["threads"] == 1)
    for roof in machine["roofline"]:
        if roof["kernel"] != "volterra":
            continue
        core = roof["rate"] / roof["operations"]
        own = [
            str(roof["modes"]), significant(roof["operations"]), significant(roof["bytes_read"]), significant(roof["bytes_distinct"]),
            significant(core), f"{100 * roof['rate'] / peak:.0f} %",
        ]  # fmt: skip
        for card, (operations, bytes_read) in CARDS.items():
            arithmetic = operations / roof["operations"] / core
            alone = bytes_read / roof["bytes_read"] / core
            cells = [*own, card, significant(arithmetic), significant(alone), significant(TOGETHER * alone)]
            found.append("| " + " | ".join(cells) + " |")
    return found


if __name__ == "__main__":
    write_blocks("docs/gpu.md", {"reckoning": lines}, sys.argv[1:])

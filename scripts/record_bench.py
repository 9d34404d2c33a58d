#!/usr/bin/env python3
"""Collects criterion's estimates into a recorded run: raw JSON and a summary table.

    .venv/bin/python scripts/record_bench.py benches/runs/NAME
"""

import json
import platform
import subprocess
import sys
from pathlib import Path


def cpu() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor()


def estimates() -> dict[str, dict[str, float]]:
    """Median and its 95 % interval in nanoseconds, by benchmark."""
    found = {}
    for file in sorted(Path("target/criterion").glob("*/*/*/new/estimates.json")):
        name = json.loads((file.parent / "benchmark.json").read_text())["full_id"]
        median = json.loads(file.read_text())["median"]
        interval = median["confidence_interval"]
        found[name] = {
            "median": median["point_estimate"],
            "low": interval["lower_bound"],
            "high": interval["upper_bound"],
        }
    return found


def main() -> None:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    found = estimates()
    commit = subprocess.run(
        ["git", "rev-parse", "HEAD"], capture_output=True, text=True, check=False
    ).stdout.strip()
    record = {
        "command": "cargo bench --bench cycle",
        "commit": commit,
        "cpu": cpu(),
        "system": platform.platform(),
        "unit": "ns",
        "estimates": found,
    }
    (folder / "raw.json").write_text(json.dumps(record, indent=1) + "\n")

    base = found["cycle/volterra/40"]["median"]
    lines = [
        f"# {folder.name}",
        "",
        f"`{record['command']}` on {record['cpu']}, commit {commit[:8]}. Medians of one run;",
        "the last column is relative to `cycle/volterra/40`.",
        "",
        "| benchmark | median [µs] | 95 % interval | ratio |",
        "|---|---|---|---|",
    ]
    for name, e in found.items():
        low, mid, high = (e[k] / 1e3 for k in ("low", "median", "high"))
        lines.append(f"| {name} | {mid:.2f} | {low:.2f} … {high:.2f} | {e['median'] / base:.2f} |")
    (folder / "summary.md").write_text("\n".join(lines) + "\n")
    print(f"recorded in {folder}")


if __name__ == "__main__":
    main()

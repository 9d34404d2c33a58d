"""Writes summary.md with `atlas machine`, STREAM and lmbench.

    python3 scripts/records/record_machine.py WORK benches/runs/NAME
"""

import json
import pathlib
import re
import shutil
import statistics
import sys

from records import keep, table


def streams(work, kind, threads):
    """Best rates of STREAM [B/s], one dictionary per turn."""
    found = []
    for path in sorted(work.glob(f"stream-{kind}-{threads}-*.txt")):
        rates = re.findall(r"^(\w+):\s+([\d.]+)", path.read_text(), re.M)
        found.append({name.lower(): 1e6 * float(rate) for name, rate in rates})
        assert "Solution Validates" in path.read_text(), path
    return found


def chains(work):
    """Latency by size [s by bytes]: medians over all turns, from the last line of every run and
    all lines of the smallest."""
    found = {}
    for path in work.glob("chain-*.txt"):
        largest = int(path.stem.split("-")[2])
        pairs = re.findall(r"^([\d.]+) ([\d.]+)$", path.read_text(), re.M)
        # Sizes are printed in MiB with five digits; all are multiples of 512 bytes.
        curve = {512 * round(2048 * float(size)): 1e-9 * float(time) for size, time in pairs}
        own = {size: time for size, time in curve.items() if size == largest << 20 or largest == 1}
        for size, time in own.items():
            found.setdefault(size, []).append(time)
    return {size: statistics.median(times) for size, times in sorted(found.items())}


def main(work, out):
    work, out = pathlib.Path(work), pathlib.Path(out)
    turns = [json.loads((path / "machine.json").read_text()) for path in sorted(work.glob("turn-*"))]
    second = json.loads((work / "second/machine.json").read_text())

    def ours(kernel, threads):
        return max(
            row["figure"]["best"]
            for turn in turns
            for row in turn["bandwidth"]
            if (row["kernel"], row["threads"], row["placement"]) == (kernel, threads, "compact")
        )

    rows, worst = [], 0.0
    threads = sorted({r["threads"] for r in turns[0]["bandwidth"] if r["placement"] == "compact"})
    kernels = {r["kernel"] for r in turns[0]["bandwidth"]}
    for count in threads:
        for mine, kind, theirs in [
            ("copy", "plain", "copy"),
            ("triad", "plain", "triad"),
            ("copy_nt", "memcpy", "copy"),
        ]:
            if mine not in kernels:
                continue
            stream = max(run[theirs] for run in streams(work, kind, count))
            atlas = ours(mine, count)
            if kind == "plain":
                worst = max(worst, abs(atlas / stream - 1))
            rows.append((str(count), mine, f"{1e-9 * atlas:.2f}",
                f"{theirs}, {kind}", f"{1e-9 * stream:.2f}", f"{atlas / stream:.3f}"))
    text = [
        "# `atlas machine` beside STREAM and lmbench, and beside itself\n",
        f"{second['description']['cpu']}, {second['host']}, {second['started']}, "
        f"{second['program']['version']} ({second['program']['commit']}), `scripts/record machine`.",
        "Quiet." if second["noise"]["quiet"] else
        "**Not quiet**: " + "; ".join(second["noise"]["remarks"]) + ".",
        f"\n## Bandwidth, GB/s, best of {len(turns)} turns\n",
        "STREAM 5.10 (J. D. McCalpin), arrays as long as those of atlas, compiled here with plain "
        "loops, and with the copy as a call of memcpy.\n",
        *table(("threads", "atlas", "", "STREAM", "", "ratio"), rows),
        f"\nPlain copies and triads differ by {100 * worst:.1f} % at most (wanted: 10 %).",
    ]
    lmbench = chains(work)
    if lmbench:
        atlas = {}
        for row in (row for turn in turns for row in turn["latency"]):
            if row["order"] == "hops" and not row["huge_pages"] and row["cpu_node"] == row["memory_node"]:
                atlas.setdefault(row["size"], []).append(row["figure"]["median"])
        sizes = [size for size in sorted(atlas) if size in lmbench]
        rows, worst = [], 0.0
        for i, size in enumerate(sizes):
            mine, theirs = statistics.median(atlas[size]), lmbench[size]
            beside = [lmbench[other] for other in sizes[max(i - 1, 0):i] + sizes[i + 1:i + 2]]
            level = any(0.8 < time / theirs < 1.25 for time in beside)
            if level:
                worst = max(worst, abs(mine / theirs - 1))
            rows.append((f"{size / 1024:.0f}", f"{1e9 * mine:.2f}", f"{1e9 * theirs:.2f}",
                f"{mine / theirs:.3f}", "" if level else "on a slope"))
        text += [
            f"\n## Time of a load from page to page, ns, medians of {len(turns)} turns\n",
            "lmbench 3.0-a9 of Debian, `lat_mem_rd -t`, lines of 64 bytes, a run a size from 1 MiB on.\n",
            *table(("buffer [KiB]", "atlas", "lmbench", "ratio", ""), rows),
            f"\nThey differ by {100 * worst:.1f} % at most, slopes left out, where half the size and "
            "twice the size both take another time by a quarter (wanted: 15 %).",
        ]
    fence = "```"
    text += [
        "\n## Two runs\n", fence, (work / "compare.txt").read_text().rstrip(), fence,
        "\n## The second one\n", fence, (work / "page.txt").read_text().rstrip(), fence,
    ]
    keep(out, text)
    shutil.copy(work / "second/machine.json", out / "machine.json")
    for name in ("solver", "roofline"):
        picture = work / f"second/pictures/machine-{name}.png"
        if picture.exists():
            shutil.copy(picture, out / picture.name)


if __name__ == "__main__":
    main(*sys.argv[1:])

"""Shared code of the programs for records and pages: places of records, how they are kept, and generated parts of pages."""

import json
import os
import platform
import re
import resource
import subprocess
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

from sources import ROOT, about, changed

TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
ATLAS = Path(os.environ.get("ATLAS", TARGET / "release/atlas"))
RUNS = ROOT / "benches/runs"
# Follows the link to a record whose sources differ from the tree.
STALE = " **(stale)**"


def output(*command: str) -> str:
    """The output of a command; empty if it cannot run."""
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def processor() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def machine() -> dict:
    return {"processor": processor(), "cores": len(os.sched_getaffinity(0)), "system": platform.platform()}


def this_run() -> dict:
    """Commit, machine and load of a record, at its end."""
    load = " ".join(f"{load:.1f}" for load in os.getloadavg())
    about = machine()
    return {"commit": output("git", "rev-parse", "HEAD") or "none", "cpu": about.pop("processor"), **about, "load": load}


def spent() -> float:
    """Processor time of the children so far, user and system [s]."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def processor_time(command: Iterable[object], **options) -> float:
    """Processor time of a command [s]. Status 3 is a run with points that failed."""
    before = spent()
    assert subprocess.run(list(map(str, command)), **options).returncode in (0, 3)
    return spent() - before


def percent(found: dict) -> str:
    """A share with its interval, in %."""
    return f"{100 * found['share']:.2f} ({100 * found['low']:.2f} to {100 * found['high']:.2f})"


def table(head: Iterable[str], rows: Iterable[Iterable[object]]) -> list[str]:
    """A Markdown table, with the empty line that ends it."""
    head = list(head)
    lines = ["| " + " | ".join(map(str, line)) + " |" for line in [head, ["---"] * len(head), *rows]]
    return [*lines, ""]


def keep(folder: str | Path, summary: str | Iterable[str], **raw: object) -> None:
    """Writes summary.md and, for each further argument NAME, its figures as NAME.json."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    text = summary if isinstance(summary, str) else "\n".join(summary)
    (folder / "summary.md").write_text(text.rstrip() + "\n")
    for name, value in raw.items():
        (folder / f"{name}.json").write_text(json.dumps(value, indent=1, ensure_ascii=False, default=float) + "\n")
    print(f"recorded in {folder}")


def the(kind: str) -> Path:
    """The newest record of a kind."""
    found = [folder for folder in RUNS.glob("*") if about(folder)["kind"] == kind]
    if not found:
        sys.exit(f"benches/runs holds no record of the kind '{kind}': scripts/record {kind}")
    return max(found, key=lambda folder: (about(folder).get("recorded", folder.name[:10]), folder.name))


def load(kind: str, file: str) -> dict:
    return json.loads((the(kind) / file).read_text())


def link(kind: str, file: str = "summary.md", text: str = "") -> str:
    """A link to a file of a record from a page of docs/, marked if the sources are older than the tree's."""
    folder = the(kind)
    return f"[{text or folder.name}](../benches/runs/{folder.name}/{file}){STALE if changed(folder) else ''}"


def without_marks(text: str) -> str:
    return text.replace(STALE, "")


def write_blocks(page: str, blocks: dict[str, Callable[[], list[str]]], arguments: list[str]) -> None:
    """Writes parts of a page, each between `<!-- NAME: begin -->` and `<!-- NAME: end -->`.

    With `--check` the page is not changed, and the status is 1 if its figures differ. Marks of stale records may differ:
    they depend on the sources, and a change of the sources alone makes no page wrong.
    """
    file = ROOT / page
    written = text = file.read_text()
    for name, lines in blocks.items():
        own = "\n".join(lines())
        own = own.replace("](../benches/", f"]({'../' * page.count('/')}benches/")
        pattern = re.compile(f"(<!-- {name}: begin -->\n).*?(\n<!-- {name}: end -->)", re.S)
        written, count = pattern.subn(lambda found, own=own: found[1] + own + found[2], written)
        if count != 1:
            sys.exit(f"{page}: {count} parts are named '{name}'; wanted: one")
    if arguments != ["--check"]:
        file.write_text(written)
    elif without_marks(written) != without_marks(text):
        sys.exit(f"the figures of {page} are not those of benches/runs: scripts/record pages")

"""Which functions of the library does no test reach? Called by `scripts/record code-coverage`.

    python3 scripts/records/record_code_coverage.py TARGET OUT [WITHOUT…]

A function counts as reached if any copy of it was entered, in a test or in a process that a test has started.
Closures, derived functions and code for tests do not count. Programs named WITHOUT are omitted.
"""

import json
import os
import re
import subprocess
import sys
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

from records import keep

from record_unsafe import counted

# Time limit of a program [s]; counts are written at its end.
LONGEST = 1800


def programs(target):
    """The programs of all tests by name, and those that they start."""
    environment = os.environ | {
        "ATLAS_RUSTFLAGS": "-C instrument-coverage -C debuginfo=0",
        "RUSTC_WRAPPER": str(Path("scripts/rustc-own").resolve()),
        "CARGO_TARGET_DIR": str(target),
        "LLVM_PROFILE_FILE": "/dev/null",
    }
    # It compiles in a third of the time.
    quick = ["--config", "scripts/quick.toml"]
    command = ["cargo", *quick, "test", "--release", "--workspace", "--no-run", "--message-format", "json"]
    said = subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE, text=True).stdout
    tests, started = {}, []
    for message in map(json.loads, said.splitlines()):
        if message["reason"] == "compiler-artifact" and message.get("executable"):
            name = message["target"]["name"]
            if message["profile"]["test"]:
                tests[name] = message["executable"]
            else:
                started.append(message["executable"])
    return tests, started


def entered(folder, objects):
    """How often every function of the library was entered, by file and line."""
    root, found = f"{Path('src').resolve()}/", {}
    for function in counted(folder, objects, [root]):
        file = function["filenames"][0]
        if file.startswith(root):
            place = (file.removeprefix(root), function["regions"][0][0])
            found[place] = max(found.get(place, 0), function["count"])
    return found


@cache
def source(file):
    """The lines of a file, and the first of its tests."""
    lines = (Path("src") / file).read_text().splitlines()
    tests = (n for n, text in enumerate(lines, 1) if text.startswith("#[cfg(test)]") and "mod " in lines[n])
    return lines, next(tests, len(lines) + 1)


def named(place):
    """The name of the function at a place; None if there is no function, or one for tests."""
    file, line = place
    lines, tests = source(file)
    if line >= tests or re.search(r"(^|_|/)(tests?|fixtures)(/|\.rs$)", file):
        return None
    found = re.match(r"\s*(?:pub(?:\([^)]*\))? )?(?:const |unsafe |extern \"C\" )*fn (\w+)", lines[line - 1])
    return found and found[1]


def main(target, out, *without):
    target = Path(target)
    counts = target / "counts"
    counts.mkdir(exist_ok=True)
    for old in counts.glob("*"):
        old.unlink()
    tests, started = programs(target)
    tests = {name: program for name, program in tests.items() if name not in without}
    environment = os.environ | {"LLVM_PROFILE_FILE": f"{counts}/%2m.profraw", "CARGO_MANIFEST_DIR": str(Path.cwd())}
    begun, failed = time.monotonic(), []

    def run(name):
        with open(counts / f"{name}.txt", "w") as said:
            command = ["timeout", str(LONGEST), tests[name]]
            ended = subprocess.run(command, env=environment, stdout=said, stderr=said).returncode
        print(f"{name}: {'passed' if ended == 0 else ended}", flush=True)
        failed.extend([name] * (ended != 0))

    libraries = [name for name in tests if name.startswith("gearatlas_") or name == "atlas"]
    for name in libraries:
        run(name)
    by_units = entered(counts, [tests[name] for name in libraries])
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(run, [name for name in tests if name not in libraries]))
    by_all = entered(counts, [*tests.values(), *started])
    write(out, by_units, by_all, (sorted(failed), without), time.monotonic() - begun)


def write(out, by_units, by_all, left, seconds):
    """summary.md."""
    failed, without = left
    functions = {place: name for place in by_all if (name := named(place))}
    module = lambda place: place[0].split("/")[1].removesuffix(".rs")
    total = Counter(map(module, functions))
    units = Counter(module(place) for place in functions if by_units.get(place))
    every = Counter(module(place) for place in functions if by_all[place] or by_units.get(place))
    lines = [
        "# Functions that tests reach",
        "",
        f"`scripts/record code-coverage`: the programs of `cargo test`, {seconds / 60:.0f} minutes. Closures, derived functions and those of tests are not counted.",
        *([f"These programs were left out: {', '.join(without)}."] if without else []),
        *([f"These programs did not pass, so that more may be reached: {', '.join(failed)}."] if failed else []),
        "",
        "| module | functions | reached by unit tests | by all tests | by none |",
        "|---|---|---|---|---|",
    ]
    for name, count in [*sorted(total.items()), ("all", total.total())]:
        own, both = (units[name], every[name]) if name != "all" else (units.total(), every.total())
        lines.append(f"| {name} | {count} | {own} ({own / count:.0%}) | {both} ({both / count:.1%}) | {count - both} |")
    lines += ["", "Reached by none:", ""]
    for place in sorted(functions):
        if not (by_all[place] or by_units.get(place)):
            lines.append(f"* `src/{place[0]}:{place[1]}` `{functions[place]}`")
    keep(out, lines)


if __name__ == "__main__":
    main(*sys.argv[1:])

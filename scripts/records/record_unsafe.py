"""Which `unsafe` did instrumented programs execute? Appends a table of all of them to a summary.

    python3 scripts/records/record_unsafe.py SUMMARY PROFILES

PROFILES has one folder per row of the summary: counts of programs built with `-Cinstrument-coverage` (`*.profraw`),
the programs' paths, one per line (`programs`), and a description of the run (`about`). The count of an `unsafe` is
that of the regions of the coverage map that begin in its block. If there are none, it is that of the smallest region
around it. Counts are summed over copies of the function. The region of code from a macro may be in the caller. Such a
place is reported as not seen, which is not the same as never executed.
"""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

SETS = ["avx512", "avx2", "baseline"]


def tool(name):
    """A program of the compiler's version of LLVM: the format of counts depends on the version."""
    about = subprocess.run(["rustc", "-vV"], check=True, capture_output=True, text=True).stdout
    major = re.search(r"^LLVM version: (\d+)", about, re.M)[1]
    found = shutil.which(f"{name}-{major}")
    return found or sys.exit(f"{name}-{major} is missing: apt-get install llvm-{major}")


def places():
    """Every `unsafe` block in the code of `src`: file, start and end of the block, text of its line."""
    found = []
    for path in sorted(Path("src").rglob("*.rs")):
        lines = [line.split("//")[0] for line in path.read_text().splitlines()]
        for number, code in enumerate(lines, 1):
            for at in re.finditer(r"\bunsafe \{", code):
                found.append((str(path), (number, at.start() + 1), block_end(lines, number, at.end()), code.strip()))
    return found


def block_end(lines, number, column):
    """The end of a block whose brace is before a column."""
    depth = 1
    while True:
        for at, character in enumerate(lines[number - 1][column:], column + 1):
            depth += (character == "{") - (character == "}")
            if depth == 0:
                return number, at
        number, column = number + 1, 0


def counted(folder, programs, files):
    """Functions of some programs and source files, with their regions and the counts in a folder."""
    profile = folder / "merged.profdata"
    raw = [str(path) for path in folder.glob("*.profraw")]
    if not raw:
        return []
    # A killed process may have left a truncated file.
    subprocess.run([tool("llvm-profdata"), "merge", "-sparse", "-failure-mode=all", "-o", profile, *raw], check=True)
    objects = [part for program in programs[1:] for part in ("-object", program)]
    command = [tool("llvm-cov"), "export", programs[0], *objects, f"-instr-profile={profile}", "-skip-expansions"]
    command += ["-sources", *(str(Path(file).resolve()) for file in files)]
    said = subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout
    return json.loads(said)["data"][0]["functions"]


def times(functions, file, begin, end):
    """Number of executions of a block, and the instruction sets of the executed copies."""
    total, sets = 0, set()
    for function in functions:
        own = [r for r in function["regions"] if r[7] == 0 and function["filenames"][r[5]].endswith(file)]
        inside = [r for r in own if begin <= (r[0], r[1]) < end]
        around = [r for r in own if (r[0], r[1]) <= begin < (r[2], r[3])]
        smallest = sorted(around, key=lambda r: (r[2] - r[0], r[3] - r[1]))[:1]
        count = max((r[4] for r in inside or smallest), default=0)
        total += count
        if count:
            sets |= {name for name in SETS if name in function["name"]}
    return total, sets


def main(summary, profiles):
    asked = places()
    files = sorted({file for file, *_ in asked})
    runs = {}
    for folder in sorted(Path(profiles).iterdir()):
        runs[(folder / "about").read_text().strip()] = counted(folder, (folder / "programs").read_text().split(), files)
    lines = [
        "",
        "Every `unsafe`, and how often which of these tests executed it:",
        "",
        "| file | line | code | executed by | copies for |",
        "|---|---|---|---|---|",
    ]
    never = 0
    for file, begin, end, code in asked:
        by, sets = [], set()
        for about, functions in runs.items():
            count, copies = times(functions, file, begin, end)
            sets |= copies
            by += [f"{about} ({count})"] * (count > 0)
        never += not by
        code = code.replace("|", "\\|")
        copies = ", ".join(name for name in SETS if name in sets)
        lines.append(f"| `{file}` | {begin[0]} | `{code}` | {', '.join(by) or '**not seen**'} | {copies} |")
    lines += ["", f"{len(asked)} places, {never} of them not seen."]
    with open(summary, "a") as out:
        out.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])

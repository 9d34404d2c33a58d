"""Counts the findings of a campaign of libFuzzer, target by target, and writes summary.md.

    python3 scripts/records/record_fuzz.py target/fuzz benches/runs/NAME SECONDS TARGET…

Runs the target again with each artifact. The output distinguishes a wrong answer from a crash.
"""

import os
import pathlib
import re
import subprocess
import sys

from records import keep


def said(program, target, artifact):
    """The line of the output that names the failure of an input."""
    environment = os.environ | {"ATLAS_FUZZ_TARGET": target, "ASAN_OPTIONS": "detect_leaks=0"}
    command = [program, "-timeout=60", "-rss_limit_mb=3000", "-malloc_limit_mb=1000", artifact]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, errors="replace")
    lines = done.stderr.splitlines()
    for mark in ["WRONG: ", "ERROR: AddressSanitizer", "ERROR: libFuzzer"]:
        for line in lines:
            if mark in line:
                return line[line.index(mark) :][:200]
    for first, line in enumerate(lines):
        if "panicked at" in line:
            return " ".join(lines[first : first + 2])[:200]
    return f"not again (status {done.returncode})" if done.returncode else "not again"


def main(folder, out, seconds, targets):
    folder = pathlib.Path(folder)
    about = dict(line.split("\t") for line in (folder / "targets").read_text().splitlines())
    rows, kinds, broken = [], [], 0
    for target in targets:
        log = (folder / "logs" / target).read_text(errors="replace")
        counts = re.findall(r"^#(\d+): cov: (\d+) ft: (\d+) corp: (\d+) .*?time: (\d+)s", log, re.M)
        inputs, coverage, features, corpus, took = counts[-1] if counts else ("0", "-", "-", "-", "-")
        found = {}
        for artifact in sorted((folder / "artifacts" / target).iterdir()):
            found.setdefault(said(folder / "release/target", target, artifact), []).append(artifact.name)
        again = {what: names for what, names in found.items() if not what.startswith("not again")}
        wrong = sum(what.startswith("WRONG") for what in again)
        hangs = sum("timeout" in what for what in again)
        crashes = len(again) - wrong - hangs
        broken += len(again)
        rows.append(
            f"| {target} | {about[target]} | {inputs} | {took} | {coverage} | {corpus} | {crashes} | {hangs} | {wrong} |"
        )
        kinds += [f"* {target}, {len(names)} inputs: `{what}`" for what, names in found.items()]
    text = [
        "# Targets under libFuzzer",
        "",
        f"`scripts/fuzz {seconds}`, with AddressSanitizer in the crate atlas; kinds of what was found, not inputs, are counted.",
        "",
        "| target | what it tries | inputs | seconds | edges | corpus | crashes | hangs | wrong results |",
        "|---|---|---|---|---|---|---|---|---|",
        *rows,
        "",
        *kinds,
    ]
    keep(out, text)
    sys.exit(1 if broken else 0)


if __name__ == "__main__":
    main(*sys.argv[1:4], sys.argv[4:])

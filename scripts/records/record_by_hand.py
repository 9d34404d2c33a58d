#!/usr/bin/env python3
"""Turns the output of benches/peers/src/bin/by_hand.rs into a recorded run: raw JSON, summary.

    .venv/bin/python scripts/records/record_by_hand.py RAW benches/runs/NAME
"""

import json
import sys
from pathlib import Path

from record_peers import power, significant
from records import keep, output, table, this_run

# Half gaps, and parts of a tangent's length.
ACCEPTED = 1e-9
NAMES = ["peer", "closed_modes", "volterra"]
KINDS = {"bare": "bare", "tangent": "one tangent"}


def rows(cases: list[dict]) -> list[list[str]]:
    """Microseconds per cycle of all programs, bare and with a tangent, and times of kernels over that of the peer."""
    found = []
    for kind, words in KINDS.items():
        times = [{name: 1e6 * case[name][kind][1] for name in NAMES} for case in cases]
        found += [[f"{name}, {words}", *(significant(time[name]) for time in times)] for name in NAMES]
        found += [
            [f"{name} / peer, {words}", *(significant(time[name] / time["peer"]) for time in times)]
            for name in NAMES[1:]
        ]
    for place, (tangents, _) in enumerate(cases[0]["many_tangents"]):
        times = [1e6 * case["many_tangents"][place][1][1] for case in cases]
        found += [[f"closed_modes, {tangents} tangents", *map(significant, times)]]
    return found


def main() -> None:
    record = json.loads(Path(sys.argv[1]).read_text())
    folder = Path(sys.argv[2])
    cases = record["cases"]
    for case in cases:
        apart = [case["distance"], case["tangent_distance"]]
        # Written so that NaN is refused.
        if not all(d <= ACCEPTED for d in apart):
            sys.exit(
                f"record_by_hand: at {case['modes']} modes the peer's motion and tangent are {apart} from those of volterra; "
                f"at most {ACCEPTED} is accepted"
            )
    compilers = [output("rustc", "--version"), output("clang", "--version").split("\n")[0]]
    record = {"command": "scripts/record by-hand", **this_run(), "compilers": compilers, "unit": "s", **record}
    heads = [f"N = {case['modes']}" for case in cases]
    lines = [
        f"# {folder.name}",
        "",
        f"`scripts/record by-hand` on {record['cpu']} ({cases[0]['instructions']}), {record['cores']} cores, load average {record['load']}",
        f"at the end; commit {record['commit'][:8]}, {', '.join(compilers)}.",
        "",
        "A mesh cycle of the default drive (`manifests/flex80.toml`) with mirrored flanks and without friction, at 1200 rad/s and",
        "5 % load, all rattling, by number of modes. The peer is `benches/peers/by_hand/peer.c`, written by hand for this drive. All run in one",
        f"process on one thread, in turn: medians of processor time over {record['stretches']} stretches of {record['stretch']} cycles, which",
        "start from the same states; each runs its stretch twice, the second time under the clock. Set-up is outside.",
        "",
        *table(["µs a cycle", *heads], rows(cases)),
        f"Over {record['compared']} cycles the peer follows `volterra` within these distances, or nothing is recorded:",
        "",
        *table(
            ["", *heads],
            [
                ["motion, half gaps", *(power(case["distance"]) for case in cases)],
                ["tangent, of its length", *(power(case["tangent_distance"]) for case in cases)],
                ["modes that a flank feels", *(str(case["felt"]) for case in cases)],
                ["events a cycle", *(f"{case['events_per_cycle']:.2f}" for case in cases)],
            ],
        ),
        "The peer leaves out the modes that no flank feels, and it does not prove that it misses no event. Both kernels move",
        "all modes and prove every interval.",
        "",
    ]
    keep(folder, lines, raw=record)


if __name__ == "__main__":
    main()

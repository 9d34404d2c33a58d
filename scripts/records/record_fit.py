"""How often the joint 95 % region of a fit holds the truth.

    scripts/record fit

The drive and the keys are those of tests/python/test_package_fit.py: damping and half gap of an oscillator that strikes both
flanks, from points with normal errors of 2 %, known or estimated from the residuals, 100 repetitions each.
"""

import sys

import gearatlas
from records import keep
from test_package_fit import KEYS, SPEEDS, TRUTH, manifest, noisy

REPETITIONS = 100
PART = 0.02


def main(folder: str) -> None:
    changes = {**TRUTH, "grid.speed": {"values": SPEEDS.tolist()}}
    curve = gearatlas.run(manifest(), set=changes, progress=False).points["deflection_rms"]
    lines = [
        "# Coverage of the regions of fits\n",
        f"`scripts/record fit`, package {gearatlas.__version__} ({(gearatlas.COMMIT or 'unknown')[:12]}): {REPETITIONS} repetitions, "
        f"{len(SPEEDS)} points with errors of {100 * PART:g} %, keys {', '.join(KEYS)}.\n",
        "| errors | truth inside the joint region | inside each interval | curves computed per fit |",
        "|---|---|---|---|",
    ]
    for words in ("known", "estimated"):
        joint, each, curves = 0, [0] * len(KEYS), 0
        for seed in range(REPETITIONS):
            points = noisy(curve, PART, 1000 + seed)
            if words == "estimated":
                del points["stderr"]
            fit = gearatlas.fit(manifest(), points, KEYS)
            joint += fit.inside(TRUTH)
            curves += fit.evaluations
            for place, (low, high) in enumerate(fit.intervals()):
                each[place] += bool(low <= TRUTH[KEYS[place]] <= high)
        told = ", ".join(f"{key} {count}" for key, count in zip(KEYS, each))
        lines.append(f"| {words} | {joint} of {REPETITIONS} | {told} | {curves / REPETITIONS:.1f} |")
    print("\n".join(lines))
    keep(folder, lines)


if __name__ == "__main__":
    main(*sys.argv[1:])

"""What does a call of the Python package's cycle map cost in addition to the kernel, and how fast is a batch?

    scripts/record python-map

A thousand states of a trajectory are mapped at once, over one cycle and over many. The time per state
and cycle over many cycles is the kernel's. The additional time of one cycle is the call's. On one
thread; medians of alternating repetitions, and the fastest.
"""

import pathlib
import sys
import time
from collections.abc import Callable, Iterator

import numpy as np

import gearatlas
from records import keep

BATCH = 1000
MANY = 100
REPETITIONS = 31


def seconds(work: Callable[[], object]) -> float:
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def attractor(mapped: gearatlas.CycleMap) -> np.ndarray:
    """States of one trajectory, a cycle apart, after a transient."""
    states = [mapped(mapped.start(), 1000)]
    while len(states) < BATCH:
        states.append(mapped(states[-1]))
    return np.array(states)


def measure(mapped: gearatlas.CycleMap) -> Iterator[str]:
    """Lines of a table."""
    states = attractor(mapped)
    works = {
        "one cycle": lambda: mapped(states),
        f"{MANY} cycles": lambda: mapped(states, MANY),
        "one cycle, a state a call": lambda: [mapped(state) for state in states[:100]],
        "one cycle, with the jacobian": lambda: mapped.image(states, jacobian=True),
        "one cycle, with events": lambda: mapped.image(states, events=True),
    }
    taken: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(REPETITIONS):
        for name, work in works.items():
            taken[name].append(seconds(work))
    each = {name: np.median(times) / (100 if "a call" in name else BATCH) for name, times in taken.items()}
    least = {name: min(times) / (100 if "a call" in name else BATCH) for name, times in taken.items()}
    for name in works:
        yield f"| {name} | {1e6 * each[name]:.2f} | {1e6 * least[name]:.2f} |"
    for words, found in (("median", each), ("fastest", least)):
        kernel = found[f"{MANY} cycles"] / MANY
        over = found["one cycle"] - kernel
        yield (
            f"| {words}: kernel {1e6 * kernel:.2f} µs a cycle, {1e6 * over:.2f} µs a state on top, "
            f"throughput {100 * kernel / found['one cycle']:.0f} % of the kernel's | | |"
        )


def main(folder: str) -> None:
    text = pathlib.Path("manifests/quickstart.toml").read_text()
    lines = [
        "# The cycle map from Python\n",
        f"`scripts/record python-map`, one thread, package {gearatlas.__version__} ({gearatlas.COMMIT[:12]}), batches of {BATCH} states along a "
        f"trajectory of `manifests/quickstart.toml` (load 0.1, 6000 rpm), {REPETITIONS} repetitions in turn.",
    ]
    for modes in (6, 12, 40):
        changed = {"model.modes": modes, "model.retained": modes}
        point = gearatlas.load(text, set=changed).point(load=0.1, speed="6000 rpm")
        lines += [f"\n{modes} modes:\n", "| call | median [µs a state] | fastest |", "|---|---|---|"]
        lines += measure(gearatlas.CycleMap(point, threads=1))
    print("\n".join(lines))
    keep(folder, lines)


if __name__ == "__main__":
    main(*sys.argv[1:])

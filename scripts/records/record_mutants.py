"""Samples the mutants of some modules, runs each with the tests of its module that reach it, and records the survivors.

Every test first runs alone without a mutant, to find the switches that it passes. `--only FILE` tries the survivors of
an earlier record again and rewrites the record. `judged.json` in its folder gives by the name of a mutant why it
changes nothing; such mutants are not tried. `words` in mutants.json has remarks on the origin of a record that the
summary would not have.
"""

import argparse
import json
import math
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from mutant_switches import SWITCH, Switched, listed

# Integration tests of a module, in addition to its unit tests, quick ones first.
TESTS = {
    "numerics": ["golden", "volterra", "exponents", "events", "any_drive"],
    "model": [
        *["golden", "dynamics", "events", "coast_flank", "bearing_forces", "reference", "mesh_pairs", "trains", "release", "mesh_course"],
        *["any_drive", "impacts", "dry_friction", "hysteresis", "film"],
    ],
    "propagate": [
        *["golden", "volterra", "stepping", "events", "kernel_tables", "release", "mesh_pairs", "mesh_course"],
        *["any_drive", "impacts", "dry_friction", "hysteresis", "film", "varying_speed"],
    ],
    "analysis": [
        *["golden", "analysis", "nvh", "orbits", "exponents", "settling", "nvh_stop", "horizon", "trace", "contact_jumps"],
        *["continuation", "followed", "multistability", "sensitivity", "basins", "lifetime", "verdicts", "steady_contact"],
    ],
    "gear": [
        *["golden", "gear_geometry", "gear_published", "gear_compliance", "sharing", "mesh_table", "mesh_pairs"],
        *["flank_points", "tooth_errors", "tooth_faults", "losses", "helical", "table_course", "ring_teeth"],
    ],
    "shaft": [
        *["golden", "structure_published", "helical_shafts", "trains", "structure_reference"],
        *["mesh_structure", "tiers", "planetary", "planetary_frames", "bearings", "housing"],
    ],
}


# The crate below `src` with a module.
CRATES = {"numerics": "core", "model": "core", "propagate": "core", "analysis": "core", "gear": "gears", "shaft": "gears"}

# Mutants that are tested at the same time.
AT_ONCE = max(1, len(os.sched_getaffinity(0)))

# Longest time of a test without a mutant [s]. Slower ones are left out: the test of a mutant may take six times as long.
LONGEST_TEST = 120

# Address space of a test, in bytes.
MOST_MEMORY = 8 << 30


def run(command, **options):
    return subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE, **options).stdout


def mutants_of(module):
    """All mutants of the files of a module, without files of tests."""
    files = sorted(Path(f"src/{CRATES[module]}/{module}").rglob("*.rs"))
    working = [file for file in files if "tests" not in file.parts and not file.stem.endswith("tests")]
    found = [mutant for file in working for mutant in listed(file.read_bytes(), str(file))]
    print(f"{module}: {len(found)} mutants", flush=True)
    return found


def changed_lines(since):
    """The lines that differ from an earlier commit, by file. A moved file keeps its lines."""
    lines, name = {}, None
    for line in run(["git", "diff", "--find-renames", "--unified=0", since, "--", "src"]).splitlines():
        if line.startswith("+++ "):
            name = line.removeprefix("+++ ").removeprefix("b/")
        elif hunk := re.match(r"@@ .* \+(\d+)(?:,(\d+))? @@", line):
            first, count = int(hunk[1]), int(hunk[2] or 1)
            lines.setdefault(name, set()).update(range(first, first + count))
    return lines


def copy_tree(scratch):
    """Copies the working tree's files that git tracks."""
    tree = scratch / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    names = run(["git", "ls-files", "-z"]).split("\0")
    for name in filter(None, names):
        if name.startswith(("benches/runs/", "docs/pictures/")) or not Path(name).is_file():
            continue
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(name, tree / name)
    # Dependencies are the same in any folder.
    run(["scripts/instrumented-target", str(scratch / "target")])
    return tree


def switch_on(tree, mutants, files):
    """Writes the sources with the switches of the mutants."""
    # A file without remaining mutants gets its original text.
    for name in files:
        own = [mutant for mutant in mutants if mutant["file"] == name]
        (tree / name).write_text(Switched(Path(name).read_bytes(), own).text())
    for crate in {Path(name).parts[1] for name in files}:
        (tree / f"src/{crate}/mutants.rs").write_text(SWITCH)
        root = Path(f"src/{crate}/lib.rs").read_text().replace("pub mod ", "pub mod mutants;\npub mod ", 1)
        (tree / f"src/{crate}/lib.rs").write_text(root)


def cargo(scratch, tree, arguments):
    environment = os.environ | {"CARGO_TARGET_DIR": str(scratch / "target"), "CARGO_INCREMENTAL": "1"}
    # A third of the time to compile; tests take little longer. Without symbols programs take a tenth of the room.
    settings = ["--config", "scripts/quick.toml", "--config", "profile.release.strip='symbols'"]
    command = ["cargo", *settings, *arguments, "--release", "--message-format=json"]
    done = subprocess.run(command, cwd=tree, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    messages = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    return done.returncode, messages, done.stderr


def viable(scratch, tree, mutants):
    """Drops mutants until the rest compiles."""
    dropped = {}
    for turn in range(12):
        left = [mutant for mutant in mutants if mutant["number"] not in dropped]
        switch_on(tree, left, sorted({mutant["file"] for mutant in mutants}))
        # No `check`: it would compile dependencies again.
        code, messages, said = cargo(scratch, tree, ["test", "--no-run", "--workspace", "--lib"])
        errors = [m["message"] for m in messages if m["reason"] == "compiler-message" and m["message"]["level"] == "error"]
        if code == 0:
            return [mutant for mutant in mutants if mutant["number"] not in dropped], dropped
        before = len(dropped)
        for error in errors:
            for span in error["spans"]:
                for mutant in left:
                    first, last = mutant["rows"]
                    if mutant["file"] == span["file_name"] and first <= span["line_end"] and span["line_start"] <= last:
                        dropped.setdefault(mutant["number"], error["message"])
        print(f"compiled {turn}: {len(errors)} errors, {len(dropped)} mutants dropped", flush=True)
        if len(dropped) == before:
            sys.exit(said[-4000:])
    sys.exit("the mutants do not compile")


def built(scratch, tree, tests):
    """Builds the unit tests and some integration tests. Returns their programs by name."""
    arguments = ["test", "--no-run", "--workspace", "--lib", *(part for test in tests for part in ("--test", test))]
    code, messages, said = cargo(scratch, tree, arguments)
    if code:
        sys.exit(said[-4000:])
    programs = {}
    for message in messages:
        if message["reason"] == "compiler-artifact" and message.get("executable") and message["profile"]["test"]:
            programs[message["target"]["name"]] = message["executable"]
    return programs


class Test:
    """A test by its name in one of the programs."""

    def __init__(self, suite, program, name):
        self.suite, self.program, self.name = suite, program, name
        self.reaches, self.seconds = set(), 0.0

    def run(self, tree, mutant, limit, reached=None):
        """`killed`, `timeout`, or None."""
        environment = os.environ | {"ATLAS_MUTANT": str(mutant), "RUST_BACKTRACE": "0", "CARGO_MANIFEST_DIR": str(tree)}
        if reached:
            environment["ATLAS_MUTANTS_REACHED"] = str(reached)
        # Kills the processes that a test has started at once too, since one that loops would continue. Limits their memory.
        bounds = ["prlimit", f"--as={MOST_MEMORY}", "timeout", "--signal=KILL", f"{limit:.0f}"]
        command = ["nice", "-n", "19", *bounds, self.program, "--exact", self.name, "--test-threads=1"]
        code = subprocess.run(command, cwd=tree, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode
        return "timeout" if code in {-signal.SIGKILL, 128 + signal.SIGKILL} else "killed" if code else None

    def trace(self, tree, scratch):
        """Records which mutants it reaches, and its time."""
        with tempfile.TemporaryDirectory(dir=scratch) as folder:
            reached, begun = Path(folder) / "reached", time.monotonic()
            ended = self.run(tree, "trace", LONGEST_TEST, reached)
            self.seconds = time.monotonic() - begun
            if ended == "timeout":
                print(f"left out, it takes longer than {LONGEST_TEST} s: {self.suite} {self.name}", flush=True)
                return
            if ended:
                sys.exit(f"{self.suite} {self.name}: {ended} without a mutant")
            if reached.exists():
                self.reaches = {int(line) for line in reached.read_text().split()}


def program_of(test):
    """The program with a file of tests: its folder. `golden` is a folder itself."""
    files = [*Path("tests").glob(f"*/{test}.rs"), *Path("tests").glob(f"{test}/main.rs")]
    return files[0].parent.name if files else sys.exit(f"record: there are no tests named {test}")


def tests_of(module, programs):
    """The tests of a module."""
    suites = [(f"gearatlas_{CRATES[module]}", [f"{module}::"])] + [
        (program_of(test), [] if test == "golden" else [f"{test}::"]) for test in TESTS[module]
    ]
    found = []
    for suite, filters in suites:
        listing = run([programs[suite], *filters, "--list", "--format", "terse"], stderr=subprocess.DEVNULL)
        ignored = run([programs[suite], *filters, "--list", "--format", "terse", "--ignored"], stderr=subprocess.DEVNULL)
        names = [line.removesuffix(": test") for line in listing.splitlines() if line.endswith(": test")]
        found += [Test(suite, programs[suite], name) for name in names if f"{name}: test" not in ignored.splitlines()]
    return found


def fate(mutant, tests, tree):
    """The fate of a mutant: runs the tests that reach it, quick ones first, until one fails."""
    reaching = sorted((test for test in tests if mutant["number"] in test.reaches), key=lambda test: test.seconds)
    for test in reaching:
        ended = test.run(tree, mutant["number"], 10 + 6 * test.seconds)
        if ended:
            return ended, f"{test.suite} {test.name}"
    return "survived", f"{len(reaching)} tests reach it" if reaching else "no test reaches it"


def wilson(killed, tried):
    """Wilson's 95 % interval of a share."""
    z, share = 1.96, killed / tried
    middle = (share + z * z / (2 * tried)) / (1 + z * z / tried)
    half = z * math.sqrt(share * (1 - share) / tried + z * z / (4 * tried * tried)) / (1 + z * z / tried)
    return middle - half, middle + half


def sampled(asked, modules):
    """A seeded sample of the mutants of some modules, and the counts of all."""
    found, counts = [], {}
    changed = changed_lines(asked.since) if asked.since else {}
    for module in modules:
        mutants = mutants_of(module)
        if asked.since:
            mutants = [m for m in mutants if m["rows"][0] in changed.get(m["file"], ())]
        drawn = random.Random(f"{asked.seed} {module}").sample(mutants, min(asked.sample, len(mutants)))
        counts[module] = {"mutants": len(mutants), "sampled": len(drawn)}
        for mutant in drawn:
            mutant |= {"module": module, "number": len(found) + 1}
            found.append(mutant)
    return found, counts


def earlier(path):
    """A record, with the judgements in its folder."""
    judged = path.parent / "judged.json"
    return json.loads(path.read_text()) | {"judged": json.loads(judged.read_text()) if judged.exists() else {}}


def survivors(records, modules):
    """The mutants of some modules of records that survived and are not judged to change nothing."""
    names = {
        m["name"]: m["module"]
        for record in records
        for m in record["mutants"]
        if lives(m) and m["name"] not in record["judged"] and m["module"] in modules
    }
    found = []
    for module in sorted(set(names.values())):
        mutants = mutants_of(module)
        for name in (name for name, own in names.items() if own == module):
            what, line = placed(name)
            alike = [mutant for mutant in mutants if placed(mutant["name"])[0] == what]
            if alike:
                # Its line may have moved; it keeps its name in the record.
                nearest = min(alike, key=lambda mutant: abs(placed(mutant["name"])[1] - line))
                found.append(nearest | {"name": name, "module": module, "number": len(found) + 1})
            else:
                # The changed code was removed: the mutant stays a survivor of the record.
                print(f"not in the sources any more, not tried again: {name}", flush=True)
    return found


def placed(name):
    """The name of a mutant without its line, and the line."""
    path, line, what = name.split(":", 2)
    return (path, what), int(line)


def lives(mutant):
    return mutant.get("again", mutant["ended"]) == "survived"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scratch", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("modules", nargs="*", default=list(TESTS))
    parser.add_argument("--sample", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--since", help="only mutants of lines that differ from this commit")
    parser.add_argument("--unit", action="store_true", help="unit tests alone")
    parser.add_argument("--only", type=Path, action="append", help="mutants.json whose survivors are tried again; may be repeated")
    parser.add_argument("--scratch", dest="again")
    asked = parser.parse_intermixed_args()
    scratch = asked.scratch
    if asked.unit:
        TESTS.update(dict.fromkeys(TESTS, []))
    modules = asked.modules or list(TESTS)
    if asked.only:
        records = {path.parent: earlier(path) for path in asked.only}
        drawn = survivors(records.values(), modules)
    else:
        drawn, counts = sampled(asked, modules)
        record = {"sample": asked.sample, "seed": asked.seed, "since": asked.since, "modules": counts, "mutants": [], "judged": {}}
        record["tests"] = {module: TESTS[module] for module in counts}
        records = {asked.out: record}
    if drawn:
        modules = sorted({mutant["module"] for mutant in drawn})
        wanted = sorted({program_of(test) for module in modules for test in TESTS[module]})
        tree = copy_tree(scratch)
        left, dropped = viable(scratch, tree, drawn)
        for module in counts if not asked.only else []:
            counts[module]["lost"] = sum(m["module"] == module and m["number"] in dropped for m in drawn)
        programs = built(scratch, tree, wanted)
        tests = {module: tests_of(module, programs) for module in modules}
        # Programs with tests of several modules are traced once.
        known_tests = {}
        for own in tests.values():
            own[:] = [known_tests.setdefault((test.suite, test.name), test) for test in own]
        # Modules take turns, so that a run that is ended early has tried equal numbers of each.
        turns = {module: iter(range(len(left))) for module in modules}
        left.sort(key=lambda mutant: next(turns[mutant["module"]]))
        with ThreadPoolExecutor(AT_ONCE) as pool:
            begun = time.monotonic()
            list(pool.map(lambda test: test.trace(tree, scratch), known_tests.values()))
            print(f"{len(known_tests)} tests traced in {time.monotonic() - begun:.0f} s", flush=True)
            fates = pool.map(lambda mutant: fate(mutant, tests[mutant["module"]], tree), left)
            for mutant, (ended, by) in zip(left, fates):
                print(f"{ended}: {mutant['name']}: {by}", flush=True)
                if asked.only:
                    for known in (m for record in records.values() for m in record["mutants"] if m["name"] == mutant["name"]):
                        known |= {"again": ended, "again_by": by}
                else:
                    keys = ["name", "module", "kind"]
                    record["mutants"].append({key: mutant[key] for key in keys} | {"ended": ended, "by": by})
                for out, record in records.items():
                    write(out, record)
    for out, record in records.items():
        write(out, record)


def write(out, record):
    """mutants.json and summary.md."""
    out.mkdir(parents=True, exist_ok=True)
    judged = record["judged"]
    kept = {key: value for key, value in record.items() if key != "judged"}
    since = f" --since {record['since']}" if record.get("since") else ""
    (out / "mutants.json").write_text(json.dumps(kept, indent=1) + "\n")
    lines = [
        "# Mutants",
        "",
        *([record["words"], ""] if "words" in record else []),
        f"`scripts/record mutants --sample {record['sample']} --seed {record['seed']}{since}`: of the mutants of each module a sample, each put to the",
        f"tests that reach it and take less than {LONGEST_TEST} s, of the unit tests of its module"
        + "".join(f", {module}: {', '.join(tests)}" for module, tests in record["tests"].items() if tests)
        + ". The other programs of `tests/` may find more. Killed by time: a test took more than ten seconds and six times",
        "as long as without the mutant. Intervals are Wilson's at 95 %. Afterwards: survivors were put to the tests again",
        "(`--only`) once tests had been written; of what then survives, the judged ones change nothing that could be seen.",
        "",
        "| module | mutants | sampled | do not compile | tried | killed | of these by time | score | interval | killed afterwards | score | judged to change nothing | score without these |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]

    def row(name, own, counts):
        first = [mutant for mutant in own if mutant["ended"] != "survived"]
        late = sum(mutant["ended"] == "timeout" for mutant in first)
        last = [mutant for mutant in own if not lives(mutant)]
        same = sum(lives(mutant) and mutant["name"] in judged for mutant in own)
        low, high = wilson(len(first), len(own))
        lines.append(
            f"| {name} | {counts['mutants']} | {counts['sampled']} | {counts['lost']} | {len(own)} | {len(first)} | {late} "
            f"| {len(first) / len(own):.1%} | {low:.0%} to {high:.0%} | {len(last)} | {len(last) / len(own):.1%} "
            f"| {same} | {len(last) / max(1, len(own) - same):.1%} |"
        )

    for module, counts in record["modules"].items():
        own = [mutant for mutant in record["mutants"] if mutant["module"] == module]
        if own:
            row(module, own, counts)
    total = {key: sum(counts[key] for counts in record["modules"].values()) for key in ["mutants", "sampled", "lost"]}
    row("all", record["mutants"], total)
    caught = [m for m in record["mutants"] if m["ended"] == "survived" and not lives(m)]
    left = [m for m in record["mutants"] if lives(m)]
    lines += ["", "Survivors that a test kills now:", ""]
    lines += [f"* `{m['name']}`: {m['again_by']}" for m in caught]
    lines += ["", "Survivors, and why each is no fault:", "", "| mutant | reached | why |", "|---|---|---|"]
    for m in left:
        name = m["name"].replace("|", "\\|")
        lines.append(f"| `{name}` | {m.get('again_by', m['by'])} | {judged.get(m['name'], '**not judged: a fault that no test finds**')} |")
    (out / "summary.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()

"""Samples the mutants of some modules, puts each to the tests of its module, and records what survived."""

import argparse
import json
import math
import os
import random
import shutil
import subprocess
import sys
import time
from pathlib import Path

from mutant_switches import SWITCH, Switched, listed

# Integration tests that hold a module, beside the unit tests in it, quick ones first.
TESTS = {
    "numerics": ["repeated_modes", "volterra", "exponents"],
    "model": ["dynamics", "events", "coast_flank", "bearing_forces"],
    "propagate": ["volterra", "stepping", "events", "kernel_tables"],
    "analysis": ["analysis", "nvh", "orbits", "exponents"],
    "gear": ["gear_geometry", "gear_published", "gear_compliance", "sharing"],
    "shaft": ["structure_published", "repeated_modes", "helical_shafts", "trains"],
}


def run(command, **options):
    return subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE, **options).stdout


def mutants_of(module):
    """All mutants of the files of a module, those that hold tests left out."""
    files = sorted(Path(f"src/{module}").rglob("*.rs"))
    working = [file for file in files if "tests" not in file.parts and not file.stem.endswith("tests")]
    found = [mutant for file in working for mutant in listed(file.read_bytes(), str(file))]
    print(f"{module}: {len(found)} mutants", flush=True)
    return found


def copy_tree(scratch):
    """A copy of the files that git knows, of the working tree."""
    tree = scratch / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    names = run(["git", "ls-files", "-z"]).split("\0")
    for name in filter(None, names):
        if name.startswith(("benches/runs/", "docs/pictures/")) or not Path(name).is_file():
            continue
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(name, tree / name)
    target = scratch / "target"
    if not target.exists():
        # Dependencies are the same, whatever the folder.
        (target / "release").mkdir(parents=True)
        for part in ["deps", "build", ".fingerprint"]:
            if (Path("target/release") / part).exists():
                run(["cp", "-a", "--reflink=auto", f"target/release/{part}", f"{target}/release/"])
    return tree


def switch_on(tree, mutants, files):
    """Writes the sources with the switches of the mutants."""
    # A file whose mutants are all dropped gets its own text back.
    for name in files:
        own = [mutant for mutant in mutants if mutant["file"] == name]
        (tree / name).write_text(Switched(Path(name).read_bytes(), own).text())
    (tree / "src/mutants.rs").write_text(SWITCH)
    root = Path("src/lib.rs").read_text().replace("pub mod analysis;", "pub mod mutants;\npub mod analysis;")
    (tree / "src/lib.rs").write_text(root)


def cargo(scratch, tree, arguments):
    environment = os.environ | {"CARGO_TARGET_DIR": str(scratch / "target"), "CARGO_INCREMENTAL": "0"}
    # A third of the time to compile; tests take little longer.
    quick = ["--config", "profile.release.package.atlas.opt-level=1"]
    command = ["cargo", *quick, *arguments, "--release", "--message-format=json"]
    done = subprocess.run(command, cwd=tree, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    messages = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    return done.returncode, messages, done.stderr


def viable(scratch, tree, mutants):
    """Drops mutants until the rest compiles."""
    dropped = {}
    for turn in range(12):
        left = [mutant for mutant in mutants if mutant["number"] not in dropped]
        switch_on(tree, left, sorted({mutant["file"] for mutant in mutants}))
        code, messages, said = cargo(scratch, tree, ["check", "--lib"])
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
        print(f"check {turn}: {len(errors)} errors, {len(dropped)} mutants dropped", flush=True)
        if len(dropped) == before:
            sys.exit(said[-4000:])
    sys.exit("the mutants do not compile")


def built(scratch, tree, tests):
    """Builds the unit tests and some integration tests; gives their programs by name."""
    arguments = ["test", "--no-run", "--lib", *(part for test in tests for part in ("--test", test))]
    code, messages, said = cargo(scratch, tree, arguments)
    if code:
        sys.exit(said[-4000:])
    programs = {}
    for message in messages:
        if message["reason"] == "compiler-artifact" and message.get("executable") and message["profile"]["test"]:
            programs["lib" if "lib" in message["target"]["kind"] else message["target"]["name"]] = message["executable"]
    return programs


def put(program, arguments, tree, mutant, limit):
    """`killed` by the first test that fails, `timeout`, or nothing."""
    environment = os.environ | {"ATLAS_MUTANT": str(mutant), "RUST_BACKTRACE": "0", "CARGO_MANIFEST_DIR": str(tree)}
    command = ["timeout", str(limit), program, *arguments]
    with subprocess.Popen(command, cwd=tree, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        for line in process.stdout:
            if line.startswith("test ") and line.rstrip().endswith("FAILED"):
                process.terminate()
                return "killed", line.split()[1]
        code = process.wait()
    if code == 124:
        return "timeout", ""
    return ("killed", f"status {code}") if code else (None, "")


def wilson(killed, tried):
    """Interval at 95 % of a share."""
    z, share = 1.96, killed / tried
    middle = (share + z * z / (2 * tried)) / (1 + z * z / tried)
    half = z * math.sqrt(share * (1 - share) / tried + z * z / (4 * tried * tried)) / (1 + z * z / tried)
    return middle - half, middle + half


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scratch", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("modules", nargs="*", default=list(TESTS))
    parser.add_argument("--sample", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--unit", action="store_true", help="unit tests alone")
    parser.add_argument("--scratch", dest="again")
    asked = parser.parse_args()
    scratch, modules = asked.scratch, asked.modules or list(TESTS)
    tree = copy_tree(scratch)
    if asked.unit:
        TESTS.update(dict.fromkeys(TESTS, []))
    sampled, all_of = [], {}
    for module in modules:
        mutants = mutants_of(module)
        all_of[module] = len(mutants)
        drawn = random.Random(f"{asked.seed} {module}").sample(mutants, min(asked.sample, len(mutants)))
        for mutant in drawn:
            mutant |= {"module": module, "number": len(sampled) + 1}
            sampled.append(mutant)
    left, dropped = viable(scratch, tree, sampled)
    programs = built(scratch, tree, sorted({test for module in modules for test in TESTS[module]}))

    def suites(module):
        unit = [("lib", programs["lib"], [f"{module}::", "--test-threads=2"])]
        return unit + [(test, programs[test], ["--test-threads=2"]) for test in TESTS[module]]

    limits = {}
    for module in modules:
        for name, program, arguments in suites(module):
            begun = time.monotonic()
            ended, test = put(program, arguments, tree, 0, 900)
            if ended:
                sys.exit(f"{module}, {name}: {ended} by {test} without a mutant")
            limits[module, name] = 20 + 6 * (time.monotonic() - begun)
            print(f"{module} {name}: {time.monotonic() - begun:.1f} s", flush=True)
    asked.out.mkdir(parents=True, exist_ok=True)
    # Modules take turns, so that a run that is ended early has tried as many of each.
    left.sort(key=lambda mutant: (int(mutant["number"] - 1) % asked.sample, mutant["module"]))
    for mutant in left:
        module = mutant["module"]
        for name, program, arguments in suites(module):
            ended, test = put(program, arguments, tree, mutant["number"], limits[module, name])
            if ended:
                break
        mutant |= {"ended": ended or "survived", "by": f"{name} {test}".strip() if ended else ""}
        print(f"{mutant['ended']}: {mutant['name']} {mutant['by']}", flush=True)
        record(asked, all_of, sampled, dropped)


def record(asked, all_of, sampled, dropped):
    tried = [mutant for mutant in sampled if "ended" in mutant]
    keys = ["name", "module", "kind", "ended", "by"]
    (asked.out / "mutants.json").write_text(json.dumps([{key: m[key] for key in keys} for m in tried], indent=1) + "\n")
    lines = [
        "# Mutants",
        "",
        f"`scripts/mutants --sample {asked.sample} --seed {asked.seed}{' --unit' * asked.unit}`: of the mutants of each module a",
        "sample, each put to the unit tests of its module"
        + ("." if asked.unit else ", then to " + ", ".join(f"{m} ({', '.join(TESTS[m])})" for m in all_of) + "."),
        "An interval is Wilson's at 95 %. The other programs of `tests/` may find more.",
        "",
        "| module | mutants | sampled | do not compile | tried | killed | of these by time | survived | score | interval |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for module, count in all_of.items():
        own = [mutant for mutant in tried if mutant["module"] == module]
        if not own:
            continue
        killed = [mutant for mutant in own if mutant["ended"] != "survived"]
        late = sum(mutant["ended"] == "timeout" for mutant in killed)
        low, high = wilson(len(killed), len(own))
        of = [mutant for mutant in sampled if mutant["module"] == module]
        lost = sum(mutant["number"] in dropped for mutant in of)
        lines.append(
            f"| {module} | {count} | {len(of)} | {lost} | {len(own)} | {len(killed)} | {late} | {len(own) - len(killed)} "
            f"| {len(killed) / len(own):.0%} | {low:.0%} to {high:.0%} |"
        )
    lines += ["", "Survivors:", ""]
    lines += [f"* `{mutant['name']}`" for mutant in tried if mutant["ended"] == "survived"]
    (asked.out / "summary.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()

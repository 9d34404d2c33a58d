#!/usr/bin/env python3
"""Writes the tables of docs/replication.md: the paper's figures and those of the records `ladder`
(scripts/record ladder), `replication` (scripts/record replication), `machine` (scripts/record machine) and `verify` (scripts/record verify) under
benches/runs/. The paper's kernels are those of the program atlas-paper.

    .venv/bin/python scripts/records/replication.py           rewrites the tables
    .venv/bin/python scripts/records/replication.py --check   status 1 if the page differs

Every row has a record. A note states known differences between the programs or machines. Notes do not depend on the ratio.
"""

import sys

from records import link, load, the, write_blocks

# The paper's figures in its units: µs per cycle, × real time, products per cycle.
PAPER_EVENTS = {
    "strong": {"dyadic": (48, 5, 371), "hermite": (31, 8, 193), "spectral": (33, 8, 74)},
    "sparse": {"hermite": (17.2, 14, 77.7), "spectral": (14.6, 16, 29.1)},
}
PAPER_REDUCTION = {
    ("40 modes", "spectral"): (1282, 0.20, 120, 16.7),
    ("20 modes", "spectral"): (460, 0.57, 124, 16.4),
    ("20 modes + MTA", "spectral"): (488, 0.54, 124, 16.5),
    ("20 modes + MTA", "fused"): (171, 1.53, 52, 16.5),
}
PAPER_STEPS = {"2": (30, 3.3), "6": (38, 2.6), "12": (49, 2.0), "20": (79, 1.3), "40": (189, 0.53)}

GUARD = "Rows of eight guards settle most cells here without a product."
MACHINE = "Here with vectors of this machine."
DRIVE = "The paper does not give its half gap and damping."
FLIGHT = "Here a free flight is one piece over any number of cells."


def significant(value: float, digits: int = 3) -> str:
    """A number with the given digits, and an exponent if it is far from one."""
    if value == 0:
        return "0"
    if not 1e-2 <= abs(value) < 1e6:
        mantissa, exponent = f"{value:.1e}".split("e")
        return f"{mantissa}e{int(exponent)}"
    if abs(value) < 1:
        return f"{value:.{digits}g}"
    whole = len(str(int(abs(value))))
    return f"{value:.{max(0, digits - whole)}f}"


def checked() -> str:
    """The record with the checks of the paper's kernels: in the ladder's folder, or in that of `atlas verify`."""
    return "ladder" if (the("ladder") / "verify.json").exists() else "verify"


class Rows:
    """Rows of one table: the paper's place, case, unit, the paper's figure, the one here, a note on differences."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def add(self, place, case, unit, paper, here, note="") -> None:
        cells = [place, case, unit, significant(paper), significant(here), significant(here / paper, 2), note]
        self.lines.append("| " + " | ".join(cells) + " |")

    def table(self) -> list[str]:
        head = "| paper's | case | unit | paper | here | ratio | known differences |"
        return [head, "|---" * 7 + "|", *self.lines, ""]


def kernels() -> list[str]:
    """The paper's kernels on the paper's cases."""
    record = load("ladder", "raw.json")
    rows = Rows()
    for modes, (step, _) in PAPER_STEPS.items():
        ours = record["small_steps"][modes]["ns_a_step"]
        rows.add("Table 1", f"small step of 100 ns, {modes} modes", "ns", step, ours, MACHINE)
    contact = record["contact"]
    low, high = contact["2"], contact["40"]
    rows.add(
        "3.1", "constant contact, a cycle, low dimension", "ns", 61, low["fused"]["ns"],
        "The kernel here also certifies contact, counts, and checks the state.",
    )  # fmt: skip
    rows.add(
        "3.1", "10⁶ cycles of constant contact", "ns", 634, low["jump"]["ns"],
        "The jump here takes seven products, one for every 1 in the binary digits of 10⁶.",
    )  # fmt: skip
    rows.add(
        "3.1", "the same against integrating them", "×", 38000, 1e6 * low["fused"]["ns"] / low["jump"]["ns"],
        "This ratio follows from the two rows above.",
    )  # fmt: skip
    for name, kernel, theirs in [
        ("small steps", "stepping", 0.4), ("segments", "hermite", 8.0), ("fused cycle", "fused", 487.7),
    ]:  # fmt: skip
        case = f"constant contact, 40 modes, μ = 0.1: {name}"
        rows.add(
            "3.1", case, "× real time", theirs, high[kernel]["real_time"],
            MACHINE if kernel == "stepping" else "Each segment certifies contact by rows of eight guards here.",
        )  # fmt: skip
    rows.add("Table A1", "segments against fused, 200 cycles", "half gaps", 5.7e-12, high["segments_against_fused"])
    for scene, kernels_of in PAPER_EVENTS.items():
        for kernel, (time, _, products) in kernels_of.items():
            ours = record["events"][scene][kernel]
            case = f"6 modes, {scene}: {kernel}"
            sparse = " The drive is in contact as long at 1400 rad/s as at 1200." if scene == "sparse" else ""
            rows.add("Table 2", case, "products", products, ours["matvecs"], GUARD + sparse)
            rows.add("Table 2", case, "µs", time, ours["ns"] / 1e3, MACHINE)
    guards = record["events"]["strong"]["spectral"]["guard_evaluations"]
    rows.add(
        "Table 2", "6 modes, strong: spectral, guards", "evaluations", 124, guards,
        "A bound of the amplitudes clears most pieces here without one.",
    )  # fmt: skip
    for (variant, kernel), (time, _, products, rms) in PAPER_REDUCTION.items():
        ours = record["reduction"][variant][kernel]
        case = f"{variant}: {kernel}"
        rows.add("Table 3", case, "µs", time, ours["ns"] / 1e3, MACHINE)
        rows.add("Table 3", case, "products", products, ours["matvecs"], FLIGHT)
        rows.add("Table 3", f"{case}, RMS of δ", "µm", rms, 1e6 * ours["deflection_rms"], DRIVE)
    hard = record["conditioning"]
    basis = "Here both flanks share one basis of free flight and one of contact. The paper has one per segment and state."
    rows.add("Table 4", "spectral table, 40 modes", "MB", 18, 1e-6 * hard["spectral_bytes"], basis)
    rows.add("Table 4", "dyadic tables, 40 modes", "MB", 190, 1e-6 * hard["dyadic_bytes"], basis)
    plain = load("replication", "record.json")["conditioning"]
    scaled = "Here each mode's frequency scales its velocity, and the eigenvectors exclude rigid rotations."
    ours_plain = "In these coordinates a velocity is a displacement times a frequency. The paper may scale otherwise."
    for name, theirs, at in [("free flight", 8.1e5, 1), ("contact", 1e3, 0)]:
        key = name.split()[0]
        rows.add("Table 4", f"condition, {name}, displacements and velocities as they are", "1", theirs, plain[key], ours_plain)
        rows.add("Table 4", f"condition, {name}, in the kernel's coordinates", "1", theirs, hard["condition"][at], scaled)
    rows.add("Table 4", "reconstruction", "1", 1.5e-11, max(hard["reconstruction"]), "Eigenvectors are corrected here twice to first order.")
    for line in (line for check in load(checked(), "verify.json")["checks"] if check["check"] == "cycle" for line in check["lines"]):
        kernel, _, what = line["what"].partition(": ")
        if kernel in ("dyadic", "hermite", "spectral", "fused") and what.startswith("times of"):
            rows.add(
                "Table 2", f"{kernel}: {what} against an integrator of 30 digits (the paper: against its small steps)", "cycles",
                7e-15, line["value"], "This is the largest of all regimes. The paper has one regime.",
            )  # fmt: skip
    against = hard["against"]
    rows.add(
        "Table A1", "fused against spectral, one cycle", "half gaps", 4.0e-15, against["fused"],
        "This is the largest of twelve cycles of chaos in the energy norm.",
    )  # fmt: skip
    rows.add(
        "Table A1", "spectral against small steps, one cycle", "half gaps", 1e-3, against["small steps, 100 ns"],
        f"The error of small steps is of first order. A quarter of the step gives {against['small steps, 25 ns']:.0e}.",
    )  # fmt: skip
    work = record["work_precision"]
    fused = next(s for s in work["samples"] if s["solver"] == "jump")
    tight = [s for s in work["samples"] if s.get("tolerance") and s["error"] <= 1.5e-9]
    best = min(tight, key=lambda s: s["ns"])
    rows.add(
        "Figure 6", f"exact fused cycles, a solution of {work['cycles']} cycles", "ms", 5e-4, 1e-6 * fused["ns"],
        "The paper does not say which case it solves.",
    )  # fmt: skip
    rows.add("Figure 6", "its error", "half gaps", 1.2e-14, fused["error"], "The sums cover all modes of a two-level stiffness, in units of the gap.")
    rows.add(
        "Figure 6", f"adaptive solver at 1.5e-9 ({best['solver']})", "ms", 68.9, 1e-6 * best["ns"],
        "The solver here has a right-hand side of O(N) work and restarts where the stiffness steps. The paper does not describe the input of Vern7.",
    )  # fmt: skip
    path = record["single_precision"]["path"]["40 modes"]
    gain = path["spectral"]["ns"] / path["spectral, single precision"]["ns"]
    rows.add(
        "Table 5", "event path in single precision, 40 modes: speed-up of a cycle", "×", 1.0, gain,
        f"The state after one cycle is off by {path['state_error']:.0e} half gaps.",
    )  # fmt: skip
    return [
        f"The table has figures from {link('ladder')}. Conditions in the paper's coordinates come from "
        f"{link('replication', 'record.json')}. Times of events come from {link(checked(), 'verify.json')}.",
        "",
        *rows.table(),
    ]


def memory() -> list[str]:
    """Memory of the paper's machine and of this one."""
    machine, ladder = load("machine", "machine.json"), load("ladder", "raw.json")
    threads = load("replication", "record.json")["threads"]
    rows = Rows()
    if "products" in ladder:
        products = [(p["dimension"], p["bytes"], 1e-3 * p["ns"]) for p in ladder["products"]]
    else:
        products = [(o["dimension"], o["working_set"], 1e6 * o["figure"]["value"]) for o in machine["operators"] if o["kernel"] == "matvec"]
    time = {n: sorted((size, taken) for of, size, taken in products if of == n) for n in (31, 41, 81)}
    for n, theirs in [(31, 3.16), (41, 3.7), (81, 10.7)]:
        of_table = min(time[n], key=lambda at: abs(at[0] - 120 * 8 * n * n))[1]
        rows.add("Figure 4", f"a product out of 120 operators of dimension {n}", "µs", theirs, of_table, MACHINE)
    resident, spilt = time[81][0][1], time[81][-1][1]
    rows.add("Figure 5a", "a product of dimension 81, operators in cache", "µs", 1.8, resident, MACHINE)
    rows.add("Figure 5a", "the same, operators in memory", "µs", 4.8, spilt, MACHINE)
    rows.add("Figure 5a", "memory over cache", "×", 4.8 / 1.8, spilt / resident, "This ratio follows from the two rows above.")
    reads = {b["threads"]: 1e-9 * b["figure"]["value"] for b in machine["bandwidth"] if b["kernel"] == "read"}
    most = max(reads)
    rows.add("Figure 5b", "streaming reads, one core", "GB/s", 10.2, reads[1])
    rows.add("Figure 5b", f"streaming reads, most (14 threads there, {most} here)", "GB/s", 32, max(reads.values()))
    cycle = ladder["reduction"]["40 modes"]["spectral"]
    rows.add("3.4", "operators read in a cycle of 40 modes, `spectral`", "MB", 6.3, 1e-6 * cycle["matvecs"] * 8 * 81 * 81, GUARD)
    solver = {
        s["threads"]: s["figure"]["value"]
        for s in machine["solver"]
        if (s["kernel"], s["tables"], s["modes"]) == ("spectral", "shared", 40)
    } or {int(count): rates["spectral"] for count, rates in ladder["threads"].items()}
    rows.add(
        "Figure 5c", f"`spectral` on one shared table, share of proportion (56 threads there, {max(solver)} here)", "1", 26.5 / 56,
        solver[max(solver)] / solver[1] / max(solver), "Here the table lies in the last-level cache.",
    )  # fmt: skip
    seconds = threads["seconds"]
    rows.add(
        "3.4", f"80 points, `volterra`, share of proportion (56 threads there, {threads['threads']} here)", "1", 16.6 / 56,
        seconds["1"] / seconds[str(threads["threads"])] / threads["threads"],
        "`volterra` streams nothing. Its data stay in the caches of a core.",
    )  # fmt: skip
    return [
        f"The table has figures from {link('machine')}, {link('ladder')} and {link('replication', 'record.json')}. "
        "They come from two cores of a shared virtual machine. The ratios do not predict 56 threads.",
        "",
        *rows.table(),
    ]  # fmt: skip


def several(values, form=significant) -> str:
    return " / ".join(form(value) for value in values)


def motion() -> list[str]:
    """Motions in four variants of the data that the paper does not give."""
    record = load("replication", "record.json")
    variants = record["variants"]
    lines = ["| paper's | case | unit | paper | " + " | ".join(variants) + " |", "|---" * (4 + len(variants)) + "|"]

    def add(place, case, unit, paper, case_of, value) -> None:
        cells = []
        for variant in variants:
            try:
                found = value(record[case_of][variant])
            except TypeError:
                # An orbit that was not found, or an exponent without a finite horizon.
                found = None
            cells.append("none" if found is None else found if isinstance(found, str) else significant(found))
        lines.append("| " + " | ".join([place, case, unit, paper, *cells]) + " |")

    micro = lambda value: significant(1e6 * value)  # noqa: E731
    plane = "`flex80.toml`"
    add("Figure 9", f"{plane}: stable period-1 points of 80", "1", "0", "plane", lambda r: str(r["stable_period_1"]))
    add("Figure 9", f"{plane}: chaotic points of 80", "1", "80", "plane", lambda r: str(r["chaotic"]))
    add("Figure 9", f"{plane}: largest λ", "1/cycle", "9.8", "plane", lambda r: f"{r['lambda_max']:.3f} ± {r['lambda_stderr']:.3f}")
    add("Figure 9", "… at", "rad/s, load", "700, 16 %", "plane", lambda r: f"{r['lambda_at'][0]:.0f}, {100 * r['lambda_at'][1]:.0f} %")
    add("4.4", f"{plane}: mean RMS of δ", "µm", "13 … 17", "plane", lambda r: 1e6 * r["rms_mean"])
    sweep = "`speed-sweep.toml`"
    add("Figure 10", f"{sweep}: chaotic points", "1", "all", "sweep", lambda r: f"{r['chaotic']} of {r['points']}")
    add("Figure 10", f"{sweep}: least λ at 1.20 … 1.26 of the nominal speed", "1/cycle", "0.1", "sweep", lambda r: r["window_lambda"])
    probes = "`multistability.toml` at 1.00, 1.20, 1.23, 1.26"
    add("Figure 10", f"{probes}: chaotic probes of 128", "1", "128", "probes", lambda r: str(r["chaotic"]))
    add("Figure 10", f"{probes}: λ at 1.23", "1/cycle", "0.11", "probes", lambda r: r["lambda_in_window"])
    modes = "`modes.toml`"
    add("Figure 14", f"{modes}: λ at 15 / 20 / 40 modes", "1/cycle", "2.3 / 2.3 / 0.7", "modes", lambda r: several(r["lambda"], lambda v: f"{v:.2f}"))
    add("Figure 14", f"{modes}: RMS of δ at 15 / 20 / 40 modes", "µm", "14.8 / 14.5 / 13.7", "modes", lambda r: several(r["rms"], micro))
    add("Table 3", "`modes-mta.toml`: RMS of δ, 20 modes + MTA", "µm", "16.5", "modes", lambda r: micro(r["rms_augmented"]))
    add("Figure 12", f"{modes}: peak to peak of δ, 5 / 30 % load", "µm", "60", "modes", lambda r: several(r["pp"], micro))
    add("Figure 12", f"{modes}: peak to peak over RMS", "1", "4.6", "modes", lambda r: several(r["pp_over_rms"]))
    add("Figure 12", f"{modes}: first order of δ, 5 % load", "µm", "5", "modes", lambda r: micro(r["harmonics"][0][0]))
    add("Figure 12", f"{modes}: peak mesh force, 5 / 30 % load", "kN", "6.0 / 9.6", "modes", lambda r: several(f / 1e3 for f in r["force_peak"]))
    far = "`horizon.toml`, 5 % load"
    add("Figure 8", f"{far}: λ", "1/cycle", "0.9", "horizon", lambda r: r["lambda"])
    add("Figure 8", f"{far}: predicted cycles from 1e-6", "cycle", "17", "horizon", lambda r: f"{r['horizon']:.1f} ± {r['horizon_stderr']:.1f}")
    add("Figure 8", f"{far}: standard error of the mean contact force after 400 cycles, relative", "1", "0.087", "horizon", lambda r: r["force_stderr"])
    add("Figure 8", f"{far}: it falls with the cycles to the power", "1", "−0.5", "horizon", lambda r: f"{r['force_slope']:.2f}".replace("-", "−"))
    six = "`orbits/strong.toml`, 6 degrees of freedom, 5 % load"
    add("Figure 7", f"{six}: λ", "1/cycle", "0.55", "six", lambda r: r["lambda"])
    add("Figure 7", f"{six}: predicted cycles from 1e-6", "cycle", "17", "six", lambda r: r["horizon"][0])
    add("Figure 7", f"{six}: additional cycles from a start 10³ times as near", "cycle", "13", "six", lambda r: r["horizon"][-1] - r["horizon"][0])

    def multiplier(orbit) -> str:
        re, im = orbit["multiplier"]
        return f"{re:.3f}" if abs(im) < 1e-9 else f"{re:.3f} ± {abs(im):.3f}i"

    add("Figure 11", f"{six}: leading multiplier of period 1", "1", "0.373 ± 0.897i", "six", lambda r: multiplier(r["strong"]))
    add("App. E", f"{six}: a kick of 1e-5 after one return", "half gaps", "6.3e-2", "six", lambda r: r["strong"]["kick_first"])
    add("App. E", f"{six}: its growth in each return after it", "1", "1.51", "six", lambda r: r["strong"]["kick_after"])
    sparse = "`orbits/sparse.toml`, 5 % load"
    add("Figure 11", f"{sparse}: leading multiplier of period 2", "1", "1.92", "six", lambda r: multiplier(r["sparse"]))
    add("App. E", f"{sparse}: growth of a kick in each return", "1", "2.61", "six", lambda r: r["sparse"]["kick_after"])

    rows = Rows()
    # The paper's kernels are timed by scripts/record ladder.
    ladder = load("ladder", "raw.json")
    askew, drift = record["misalignment"], dict(record["drift"])
    friction = ladder.get("friction") or record["friction"]
    if "drift" in ladder:
        drift["spectral"] = ladder["drift"]
    softer = "Slices of the face support one another here."
    rows.add("2", "`misalignment.toml`, 1 mrad, 50 N m: mean stiffness by the table", "%", -42, 100 * askew["table"], softer)
    rows.add("2", "the same with compliant shafts", "%", -41, 100 * askew["loop"], softer)
    for kernel, found in drift.items():
        kept = kernel == "spectral" and "drift" in ladder
        slow = "" if kept else "The time includes the mesh of every slice from the gears, with its flanks' error."
        rows.add("Table 5", f"`misalignment-drift.toml`, `{kernel}`: five slices of drift", "× real time", 1.37, found["drifting"], slow)
        rows.add("Table 5", f"the same over five slices that are one, `{kernel}`: drift over none", "×", 1.0, found["drifting"] / found["still"])
    rows.add("3.1", "constant contact, μ = 0.1: relative difference of the RMS, fused cycles against small steps", "1", 6.25 / 5.89 - 1, friction["difference"], "Both solve the same equations here.")
    rows.add("5", "c_res k, 40 to 20 modes", "1", 1.9e-3, record["residual"])
    folder = f"../benches/runs/{the('replication').name}"
    return [
        f"The tables have figures from {link('replication', 'record.json')}, with one run each. `scripts/record replication` repeats the runs. "
        "λ is per mesh cycle. *One line* is `mesh.coast_flank = \"same_line\"`. Its coast flanks push along the drive flanks' line. "
        "*Mirrored* is the default. Its coast flanks have their own line and phase. The paper gives neither this choice nor its half gap.",
        "",
        *lines,
        "",
        *rows.table(),
        f"![Separation of twins, and the error of the mean contact force]({folder}/horizon.png)",
        f"![Orders of the deflection, and force over load]({folder}/signatures.png)",
        f"![A cycle of the deflection with 15, 20 and 40 modes]({folder}/waveform.png)",
        "",
    ]  # fmt: skip


if __name__ == "__main__":
    write_blocks("docs/replication.md", {"kernels": kernels, "memory": memory, "motion": motion}, sys.argv[1:])

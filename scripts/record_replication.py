"""The kernels' figures of a ladder run beside the paper's: the generated part of
docs/replication.md."""

from pathlib import Path

BEGIN, END = "<!-- ladder: begin -->", "<!-- ladder: end -->"

STEPS = (
    "The same method in vector lanes; at few modes the contact state and the guard of every step, "
    "which do not shrink with the modes, are most of it."
)
PRODUCTS = {
    "dyadic": "A bound of δ'' settles most cells at once, and the last stretch below Δ/2²⁰ is a "
    "polynomial, not more halving.",
    "hermite": "Rows give the guard at eight nodes of a cell without moving the state, so that one "
    "product a cell and two an event remain.",
    "spectral": "Two products a cell of contact; a free flight is one piece however many cells it "
    "spans.",
}
TIMES = {
    "dyadic": "Fewer products, wider vectors.",
    "hermite": "Fewer products, but rows of eight guards a cell.",
    "spectral": "As the products, wider vectors.",
}
SPARSE = {
    "hermite": "As in strong rattle: one product a cell whether or not events are rare.",
    "spectral": "This drive is in contact as long at 1400 rad/s as at 1200; cells as long as the "
    "closed form allows take seven or eight products.",
}
REDUCED = {
    ("40 modes", "spectral"): "Products are half as many, the core has a larger second-level cache "
    "and wider vectors: the table still streams.",
    ("20 modes", "spectral"): "Half the modes are a quarter of the table.",
    ("20 modes + MTA", "spectral"): "Residual flexibility is a change of the stiffness, no more "
    "work.",
    ("20 modes + MTA", "fused"): "Runs of up to eight cells are certified in contact; flights are "
    "one piece already.",
}


def us(value: dict) -> float:
    return value["ns"] / 1e3


def rows(record: dict, paper: dict) -> list[tuple[str, float, float, str, str]]:
    """(case, the paper's figure, ours, unit, why they differ)."""
    found = []

    def add(case: str, theirs: float, ours: float, unit: str, why: str) -> None:
        found.append((case, theirs, ours, unit, why))

    for modes, (step, _) in paper["steps"].items():
        ours = record["small_steps"][modes]["ns_a_step"]
        add(f"small step of 100 ns, {modes} modes", step, ours, "ns", STEPS)
    contact = record["contact"]
    low, high = contact["2"], contact["40"]
    add(
        "constant contact, a cycle, low dimension", 61, low["fused"]["ns"], "ns",
        "Ours also certifies that contact is kept, sets phases, counts and checks the state.",
    )  # fmt: skip
    add(
        "10⁶ cycles of constant contact", 634, low["jump"]["ns"], "ns",
        "Seven products: one for every 1 in the binary digits of 10⁶.",
    )  # fmt: skip
    add(
        "the same against integrating them", 38000, 1e6 * low["fused"]["ns"] / low["jump"]["ns"], "×",
        "Follows from the two above.",
    )  # fmt: skip
    for name, kernel, theirs, why in [
        ("small steps", "stepping", 0.4, "As in the ladder of small steps."),
        ("segments", "hermite", 8.0, "One product a segment and rows that certify it."),
        ("fused cycle", "fused", 487.7, "One 83 × 83 product with its certificate."),
    ]:
        case = f"constant contact, 40 modes, μ = 0.1: {name}"
        add(case, theirs, high[kernel]["real_time"], "× real time", why)
    add(
        "segments against fused, 200 cycles", 5.7e-12, high["segments_against_fused"], "half gaps",
        "Round-off of 24 000 products against that of 200.",
    )  # fmt: skip
    for scene, kernels in paper["events"].items():
        for kernel, (time, _, products) in kernels.items():
            ours = record["events"][scene][kernel]
            why = (PRODUCTS if scene == "strong" else SPARSE)[kernel]
            add(f"6 modes, {scene}: {kernel}", products, ours["matvecs"], "products", why)
            add(f"6 modes, {scene}: {kernel}", time, us(ours), "µs", TIMES[kernel])
    guards = record["events"]["strong"]["spectral"]["guard_evaluations"]
    add(
        "6 modes, strong: spectral, guards", 124, guards, "evaluations",
        "A bound of the amplitudes clears most pieces without one.",
    )  # fmt: skip
    for (variant, kernel), (time, _, products, rms) in paper["reduction"].items():
        ours = record["reduction"][variant][kernel]
        why = REDUCED[variant, kernel]
        add(f"{variant}: {kernel}", time, us(ours), "µs", why)
        add(f"{variant}: {kernel}", products, ours["matvecs"], "products", "As at six modes.")
        add(
            f"{variant}: {kernel}, RMS of δ", rms, 1e6 * ours["deflection_rms"], "µm",
            "The drive was deduced from figures of the paper; its half gap and damping are not given.",
        )  # fmt: skip
    hard = record["conditioning"]
    mega = 1e-6
    add(
        "spectral table, 40 modes", 18, mega * hard["spectral_bytes"], "MB",
        "One basis of free flight and one of contact for both flanks, not one a segment and state.",
    )  # fmt: skip
    add(
        "dyadic tables, 40 modes", 190, mega * hard["dyadic_bytes"], "MB",
        "The same; the quotient of the two is as published.",
    )  # fmt: skip
    add(
        "condition, free flight", 8.1e5, hard["condition"][1], "1",
        "Velocities are measured by each mode's frequency, and rigid rotations are kept out of the "
        "eigenvectors.",
    )  # fmt: skip
    add("condition, contact", 1e3, hard["condition"][0], "1", "The same scaling.")
    add(
        "reconstruction", 1.5e-11, max(hard["reconstruction"]), "1",
        "Eigenvectors are corrected twice to first order.",
    )  # fmt: skip
    against = hard["against"]
    add(
        "fused against spectral, one cycle", 4.0e-15, against["fused"], "half gaps",
        "The largest of twelve cycles of chaos in the energy norm; both are as near to the reference.",
    )  # fmt: skip
    add(
        "spectral against small steps, one cycle", 1e-3, against["small steps, 100 ns"], "half gaps",
        "First order in the step: a quarter of it gives "
        f"{against['small steps, 25 ns']:.0e}.",
    )  # fmt: skip
    samples = record["work_precision"]["samples"]
    cycles = record["work_precision"]["cycles"]
    fused = next(s for s in samples if s["solver"] == "jump")
    tight = [s for s in samples if s.get("tolerance") and s["error"] <= 1.5e-9]
    best = min(tight, key=lambda s: s["ns"])
    add(
        "work and precision: fused cycles, a solution", 5e-4, 1e-6 * fused["ns"], "ms",
        f"40 modes, {cycles} cycles; the paper does not say which case it solves.",
    )  # fmt: skip
    add(
        "its error", 1.2e-14, fused["error"], "half gaps",
        "Round-off of sixty segments in the map, in units of the gap.",
    )  # fmt: skip
    add(
        "adaptive solver at 1.5e-9", 68.9, 1e-6 * best["ns"], "ms",
        f"{best['solver']} with a right-hand side of O(N) work restarts twice a cycle; the "
        "paper does not say what Vern7 was given.",
    )  # fmt: skip
    threads = record["threads"]
    most = max(threads, key=int)
    if int(most) > 1:
        gain = threads[most]["spectral"] / threads["1"]["spectral"]
        add(
            f"threads on one spectral table ({most} here, 56 there), share of proportion",
            26.5 / 56, gain / int(most), "1",
            "Few cores here, and the table lies in the last-level cache.",
        )  # fmt: skip
    double, single = record["single_precision"]["product_ns"]["out of 122"]
    found_error = record["single_precision"]["state_error"]
    add(
        "operators in single precision, gain of a product", 1.0, double / single, "×",
        f"A product gains what its bytes shrink; a cycle's state is then off by {found_error:.0e} half "
        "gaps, so that no kernel here uses it.",
    )  # fmt: skip
    return found


def page(record: dict, paper: dict, significant, run: str) -> str:
    """The generated part."""
    lines = [
        BEGIN,
        f"From [{run}](../benches/runs/{run}/summary.md). Ratio: ours over the paper's.",
        "",
        "| case | unit | paper | here | ratio | why they differ |",
        "|---|---|---|---|---|---|",
    ]
    for case, theirs, ours, unit, why in rows(record, paper):
        cells = [case, unit, significant(theirs), significant(ours), significant(ours / theirs, 2), why]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join([*lines, END])


def rewrite(file: Path, record: dict, paper: dict, significant, run: str) -> None:
    """Puts the figures of a run into the page."""
    text = file.read_text()
    before, rest = text.split(BEGIN)
    _, after = rest.split(END)
    file.write_text(before + page(record, paper, significant, run) + after)

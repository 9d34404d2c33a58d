"""Times the run-up of manifests/run-up.toml, and writes summary.md.

    python3 scripts/records/record_run_up.py benches/runs/NAME-COMMIT [COMMIT ATLAS]
"""

import pathlib
import statistics
import subprocess
import sys
import tempfile

from records import ATLAS, ROOT, keep, processor, processor_time

TURNS = 5
CASES = {
    "force, orders 1 to 10": ["runup.signals=['force']", "runup.orders=[1,2,3,4,5,6,7,8,9,10]"],
    "24 signals, 6 orders": [],
}


def spent(program, settings):
    """Processor time of one run-up [s]."""
    with tempfile.TemporaryDirectory() as work:
        command = [program, "runup", "manifests/run-up.toml", "--threads", "1", "--out", f"{work}/out"]
        for setting in settings:
            command += ["--set", setting]
        return processor_time(command, cwd=ROOT, stdout=subprocess.DEVNULL)


def main(folder, before=None, older=None):
    folder = pathlib.Path(folder)
    programs = [*filter(None, [older]), str(ATLAS)]
    rows = []
    for name, settings in CASES.items():
        times = {program: [] for program in programs}
        for _ in range(TURNS):
            for program in programs:
                times[program].append(spent(program, settings))
        rows.append({"case": name, "seconds": [times[program] for program in programs]})
    names = [f"commit {commit}" for commit in (before, folder.name.rsplit("-", 1)[-1]) if commit]
    table = f"| recorded | {' | '.join(f'{name} [s]' for name in names)} |\n|{'---|' * (len(names) + 1)}\n"
    for row in rows:
        medians = [statistics.median(times) for times in row["seconds"]]
        table += f"| {row['case']} | {' | '.join(f'{median:.2f}' for median in medians)} |\n"
    text = f"""# Processor time of a run-up

`atlas runup manifests/run-up.toml`: 40 modes, 600 to 6000 rpm in 10 s, 48000 samples per second, all tables written. Medians of {TURNS}
runs in turn, user and system time, on one core of a shared {processor()}.

{table}"""
    keep(folder, text, record={"cpu": processor(), "rows": rows})


if __name__ == "__main__":
    main(*sys.argv[1:])

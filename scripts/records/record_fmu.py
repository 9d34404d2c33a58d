"""Steps an FMU of 40 rattling modes from a program in C, and writes summary.md.

    python3 scripts/records/record_fmu.py benches/runs/NAME [STEPS]
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import zipfile

from records import ATLAS, ROOT, keep, processor

POINT = "load=0.1,speed=1047"
OUTPUTS = ("mesh.force", "mesh.deflection", "pinion.speed", "wheel.speed", "bearing.'pinion 1 y'")


def measure(work, steps):
    program, fmu = work / "real_time", work / "drive.fmu"
    source = ROOT / "benches/fmu/real_time.c"
    subprocess.run(["cc", "-O2", "-fno-builtin", "-rdynamic", "-o", program, source, "-ldl"], check=True)
    manifest = ROOT / "manifests/flex80.toml"
    command = [ATLAS, "fmu", manifest, "--fmi", "3", "--point", POINT, "--out", fmu]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(work / "own")
    text = (work / "own/modelDescription.xml").read_text()
    references = dict(re.findall(r'name="([^"]*)" valueReference="(\d+)"', text))
    token = re.search(r'instantiationToken="([^"]*)"', text)[1]
    library = next((work / "own/binaries").glob("*/*.so"))
    asked = [references[name] for name in ("pinion.torque", "events", *OUTPUTS)]
    rows = []
    for step in (1e-3, 1e-4):
        command = [program, library, token, f"{work}/own/resources/", str(step), str(steps), *asked]
        # The last core has the fewest other processes.
        command = ["taskset", "-c", str(max(os.sched_getaffinity(0))), *command]
        rows.append(json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout))
    return rows


def main(folder, steps="1000000"):
    with tempfile.TemporaryDirectory() as work:
        rows = measure(pathlib.Path(work), int(steps))
    table = "".join(
        f"| {1e3 * row['step']:g} ms | {row['steps']} | {row['events'] / row['steps']:.2f} | {1e6 * row['median']:.1f} | "
        f"{1e6 * row['p9999']:.1f} | {1e6 * row['worst']:.0f} | {1e6 * row['mean']:.1f} | {row['allocations']} |\n"
        for row in rows
    )
    text = f"""# Time of every step of an FMU

`manifests/flex80.toml` at {POINT}: 40 modes, rattling. Each step sets a torque, steps, and reads {len(OUTPUTS)} outputs through the C
interface of FMI 3.0 (`benches/fmu/real_time.c`), on one core of a shared {processor()}, whose load average was {os.getloadavg()[0]:.1f}
at the end. Times of other programs on the core count as times of the step.

| step | steps | events a step | median [µs] | 99.99 % [µs] | worst [µs] | mean [µs] | allocations in all steps |
|---|---|---|---|---|---|---|---|
{table}
Made and initialized in {1e3 * rows[0]['made']:.0f} ms.
"""
    keep(folder, text, record={"cpu": processor(), "rows": rows})


if __name__ == "__main__":
    main(*sys.argv[1:])

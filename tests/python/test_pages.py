"""Commands of README.md and of the tutorials do what the pages say, in a clean home, and print what the pages show.

A block fenced as `sh` is run. A block fenced as `text` that follows it shows lines of what it printed, in their order; `…`
stands for any part of a line, or for any lines where it stands alone. Exponents of chaos depend on the instructions of the processor
within their errors: numbers with a point agree to a tenth, and marks of chaos in maps count as one.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from program import ATLAS, ROOT

TUTORIALS = sorted((ROOT / "docs/tutorials").glob("*.md"))
# Commands of README.md that other tests or people run, and why.
ELSEWHERE = {
    "scripts/run": "builds the program, and computes for a minute",
    "scripts/test": "is this test",
    "atlas verify": "a minute; tests/jobs/verify.rs",
    "atlas machine": "minutes; tests/jobs/machine.rs",
}
DECIMAL = r"\d+\.\d+(?:e-?\d+)?"
POINTS = "speed [rpm],deflection_rms [um]\n6000,10\n9000,12\n"


class Home:
    """A clean home with nothing but the program, and the folders of the sources that pages name."""

    def __init__(self, folder: Path, program: Path = ATLAS):
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)
        path = os.pathsep.join([str(program.parent), str(Path(sys.executable).parent), "/usr/bin", "/bin"])
        self.environment = {"HOME": str(folder), "PATH": path, "LANG": "C.UTF-8"}

    def run(self, script: str) -> str:
        """What a script prints, errors included; it must end well."""
        done = subprocess.run(
            ["bash", "-euo", "pipefail", "-c", script],
            cwd=self.folder, env=self.environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        )  # fmt: skip
        assert done.returncode == 0, f"status {done.returncode}:\n{script}\n{done.stdout}"
        return done.stdout


@pytest.fixture
def home(tmp_path) -> Home:
    if not ATLAS.exists():
        pytest.skip("no program: cargo build --release builds it")
    found = Home(tmp_path / "home")
    (found.folder / "manifests").symlink_to(ROOT / "manifests")
    return found


def blocks(page: str) -> list[tuple[str, str]]:
    """Language and text of the fenced blocks."""
    return re.findall(r"^```(\w+)\n(.*?)^```$", page, flags=re.M | re.S)


def matches(shown: str, printed: str) -> bool:
    """Whether a line of a page stands for a line that was printed."""
    if "|" in shown:
        shown, printed = (re.sub("[-=*#@]", "@", line) for line in (shown, printed))
    parts = re.split(rf"(…|{DECIMAL})", shown)
    pattern = "".join(".*" if part == "…" else f"({DECIMAL})" if place % 2 else re.escape(part) for place, part in enumerate(parts))
    found = re.fullmatch(pattern, printed)
    wanted = [float(part) for part in parts[1::2] if part != "…"]
    return found is not None and [float(own) for own in found.groups()] == pytest.approx(wanted, rel=0.1)


def missing(shown: str, printed: str) -> str | None:
    """The first line of a page's block that was not printed in its place; nothing if all were."""
    lines = iter(printed.rstrip().splitlines())
    anywhere = True
    for line in shown.splitlines():
        if line.strip() == "…":
            anywhere = True
            continue
        found = next((own for own in lines if matches(line, own.rstrip())), None) if anywhere else next(lines, "")
        if found is None or not matches(line, found.rstrip()):
            return line
        anywhere = False
    return None


def follow(home: Home, page: str) -> int:
    """Runs a page; gives the number of blocks of output that were compared."""
    compared, printed = 0, ""
    for language, text in blocks(page):
        if language == "sh":
            commands = [line for line in text.splitlines() if not any(line.startswith(name) for name in ELSEWHERE)]
            printed = home.run("\n".join(commands))
        elif language == "python":
            home.run(f"python - <<'END'\n{text}\nEND")
        elif language == "text":
            compared += 1
            assert missing(text, printed) is None, f"the page shows: {missing(text, printed)}\nprinted:\n{printed}"
    return compared


def test_output_is_compared_line_by_line():
    printed = "head\na = 1\nb = 2 in 3.1 s\n\ntail\n"
    assert missing("a = 1\nb = 2 in … s\n", printed) is None
    assert missing("a = 1\n…\ntail\n", printed) is None
    assert missing("a = 1\ntail\n", printed) == "tail"
    assert missing("b = 2 in … s\na = 1\n", printed) == "a = 1"
    assert missing("a = 2\n", printed) == "a = 2"
    assert missing("b = 2 in 3.2 s\n", printed) is None and missing("b = 2 in 3.6 s\n", printed) == "b = 2 in 3.6 s"
    assert missing("b = 3 in 3.1 s\n", printed) == "b = 3 in 3.1 s", "counts are exact"
    assert missing(" 1 * @|\n", " 1 # *|\n") is None and missing(" 1 * 1|\n", " 1 * @|\n") == " 1 * 1|"


@pytest.mark.parametrize("path", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial(path, home):
    assert follow(home, path.read_text()) >= 2


def test_the_front_page(home):
    assert follow(home, (ROOT / "README.md").read_text()) >= 1
    assert all((home.folder / "results/quickstart" / name).stat().st_size for name in ("points.parquet", "run.json"))


def test_every_task_of_the_front_page(home):
    """Commands of the table, on the quickstart with four modes in the place of `m.toml`."""
    short = (ROOT / "manifests/quickstart.toml").read_text()
    for old, new in [('name = "quickstart"', 'name = "m"'), ("modes = 12", "modes = 4")]:
        assert old in short
        short = short.replace(old, new)
    (home.folder / "m.toml").write_text(short)
    (home.folder / "points.csv").write_text(POINTS)
    rows = [line for line in (ROOT / "README.md").read_text().splitlines() if line.startswith("| ")]
    commands = [command for row in rows for command in re.findall(r"`(atlas [^`]+)`", row)]
    assert len(commands) >= 12
    complete = [command for command in commands if command not in ELSEWHERE and " " in command.removeprefix("atlas ")]
    # A folder holds a part of a job or the whole job.
    for command in (part for part in complete if "--shard" in part):
        home.run(command)
        shutil.rmtree(home.folder / "results/m")
    home.run("atlas run manifests/quickstart.toml --quiet\natlas run m.toml --quiet")
    for command in (whole for whole in complete if "--shard" not in whole):
        home.run(command)


def test_the_path_of_a_stranger(tmp_path):
    """From nothing but the program to a page of results."""
    if not ATLAS.exists():
        pytest.skip("no program: cargo build --release builds it")
    home = Home(tmp_path / "home")
    home.run("atlas new my-drive")
    assert home.run("atlas check my-drive.toml").startswith("my-drive.toml: valid\n")
    home.run("atlas run my-drive.toml --quiet\natlas report results/my-drive --quiet")
    [page] = (home.folder / "results/my-drive").rglob("*.html")
    assert page.stat().st_size > 1e5
    left = {path.name for path in home.folder.iterdir()}
    assert left == {"my-drive.toml", "results", "tables"} or left == {"my-drive.toml", "results"}, "it leaves nothing else in the home"
    shutil.rmtree(home.folder)

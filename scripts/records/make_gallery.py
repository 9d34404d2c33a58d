"""Runs the commands of docs/gallery.md and keeps their pictures. Only the page defines how each picture is made.

    .venv/bin/python scripts/records/make_gallery.py [PICTURE ...]

A section of the page has one block of commands and below it the picture `pictures/NAME`. The last command of the block
names the file that it writes after `# →` (a pattern if the name contains a checksum). That file becomes
docs/pictures/NAME. Commands run in target/gallery, each once even if several sections have it.
"""

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/gallery.md"
PICTURES = ROOT / "docs/pictures"
PLACE = ROOT / "target/gallery"

# Parts of the repository that the commands use.
NAMED = ["manifests", "docs", "examples", ".venv"]


@dataclass(frozen=True)
class Section:
    """How one picture is made."""

    picture: str
    commands: list[str]
    # The file of the last command, relative to the folder of the commands.
    written: str


def sections(page: str) -> list[Section]:
    """The sections of the page, in its order."""
    found = []
    for text in re.split(r"^## ", page, flags=re.M)[1:]:
        title = text.splitlines()[0]
        blocks = re.findall(r"^```sh\n(.*?)^```$", text, flags=re.M | re.S)
        pictures = re.findall(r"\]\(pictures/([^)]+)\)", text)
        if len(blocks) != 1 or len(pictures) != 1:
            raise SystemExit(f"{PAGE.name}, '{title}': one block of commands and one picture are wanted")
        lines = blocks[0].replace("\\\n", " ").splitlines()
        _, arrow, written = lines[-1].partition("# → ")
        if not arrow:
            raise SystemExit(f"{PAGE.name}, '{title}': the last command does not say behind `# →` what it writes")
        found.append(Section(pictures[0], [line.partition("  # ")[0].rstrip() for line in lines], written.strip()))
    return found


def make(wanted: list[str]) -> None:
    """Makes the pictures with the given names, or all."""
    chosen = [section for section in sections(PAGE.read_text()) if not wanted or section.picture in wanted]
    unknown = set(wanted) - {section.picture for section in chosen}
    if unknown:
        raise SystemExit(f"{PAGE.name} has no picture {', '.join(sorted(unknown))}")
    shutil.rmtree(PLACE, ignore_errors=True)
    PLACE.mkdir(parents=True)
    for name in NAMED:
        (PLACE / name).symlink_to(ROOT / name)
    environment = os.environ | {"PATH": f"{ROOT / 'target/release'}:{os.environ['PATH']}"}
    done = set()
    for section in chosen:
        for command in section.commands:
            if command in done:
                continue
            print(f"$ {command}", flush=True)
            subprocess.run(["bash", "-c", command], cwd=PLACE, env=environment, check=True)
            done.add(command)
        files = sorted(PLACE.glob(section.written))
        if len(files) != 1:
            raise SystemExit(f"{section.picture}: '{section.written}' is {len(files)} files")
        target = PICTURES / section.picture
        if not target.exists() or not files[0].samefile(target):
            shutil.copyfile(files[0], target)
        print(f"{target.relative_to(ROOT)}: {target.stat().st_size / 1000:.0f} kB", flush=True)


if __name__ == "__main__":
    make(sys.argv[1:])

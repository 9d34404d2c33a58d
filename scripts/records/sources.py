"""Which sources did a record measure, and are they those of the tree? Each folder of benches/runs has an `about.json`:

    kind, command, commit   kind, command and commit of the measurement; `program` is the commit from the program itself
    sources                 a hash for each file or folder that the figures depend on (kinds.toml)
    contact                 the model of the flanks: "mirrored flanks", "one line", or both
    machine, load           processor, cores, system; load averages over a minute before and after
    processor_seconds       time of all measured processes, user and system

A hash covers code: comments, blank lines, unit tests and the names and versions in Cargo.toml do not count.
"""

import functools
import hashlib
import io
import json
import re
import subprocess
import sys
import tarfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = ["README.md", "docs"]
KINDS = tomllib.loads((Path(__file__).parent / "kinds.toml").read_text())
# Possible sources of a record without a kind.
PROGRAM = ["src/core", "src/gears", "src/jobs"]
# Commits with this word in their sources mirror the flanks of a drive by default.
MIRRORED = "coast_flank"

UNIT_TESTS = re.compile(rb"^#\[cfg\(test\)\]\nmod \w+ \{\n.*?^\}\n", re.M | re.S)
NOT_CODE = re.compile(rb"^\s*(//.*)?\n", re.M)
NOT_TEXT = re.compile(rb"^\s*(#.*)?\n", re.M)
NOT_COUNTED = re.compile(r"(^|/)Cargo\.toml$|^src/.*(\btests?\.rs$|_tests?\.rs$|/tests?/)")


def git(root: Path, *arguments: str) -> bytes | None:
    """The output of git; None if it fails."""
    done = subprocess.run(["git", *arguments], cwd=root, capture_output=True)
    return done.stdout if done.returncode == 0 else None


def kind_of(folder: str) -> str:
    """The kind in the name of a record, DATE-KIND-COMMIT."""
    return re.sub(r"^\d{4}-\d\d-\d\d-|-[^-]+$", "", folder)


def programs_of(kind: str) -> list[str]:
    """The files of scripts/records that measure a kind; the first is the one to start."""
    names = [kind, f"record_{kind.replace('-', '_')}.py"]
    return [f"scripts/records/{name}" for name in names if (ROOT / "scripts/records" / name).exists()]


def paths_of(kind: str) -> list[str]:
    """Files and folders that the figures of a kind depend on."""
    return [*KINDS[kind]["sources"], *programs_of(kind)] if kind in KINDS else PROGRAM


def code(name: str, data: bytes) -> bytes:
    """The part of a file that can change a figure."""
    if name.endswith(".rs"):
        return NOT_CODE.sub(b"", UNIT_TESTS.sub(b"", data))
    return NOT_TEXT.sub(b"", data) if name.endswith((".py", ".toml")) else data


def files(root: Path, path: str, commit: str | None) -> dict[str, bytes]:
    """Contents of the files below a path, of a commit or of the working tree."""
    if commit is None:
        listed = git(root, "ls-files", "-z", "--cached", "--others", "--exclude-standard", "--", path) or b""
        names = [name for name in listed.decode().split("\0") if name and (root / name).is_file()]
        return {name: (root / name).read_bytes() for name in names}
    packed = git(root, "archive", "--format=tar", commit, "--", path)
    if packed is None:
        return {}
    with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
        return {member.name: archive.extractfile(member).read() for member in archive if member.isfile()}


@functools.cache
def digest(root: Path, path: str, commit: str | None = None) -> str | None:
    """Hash of the code below a path; None if there is none."""
    found = {name: data for name, data in files(root, path, commit).items() if not NOT_COUNTED.search(name)}
    if not found:
        return None
    total = hashlib.sha256()
    for name, data in sorted(found.items()):
        total.update(f"{name}\0".encode() + hashlib.sha256(code(name, data)).digest())
    return total.hexdigest()[:16]


def digests(kind: str, commit: str | None = None, root: Path = ROOT) -> dict[str, str | None]:
    return {path: digest(root, path, commit) for path in paths_of(kind)}


def about(folder: Path) -> dict:
    """The description in a record."""
    file = folder / "about.json"
    return json.loads(file.read_text()) if file.exists() else {"kind": kind_of(folder.name)}


def changed(folder: Path, root: Path = ROOT) -> list[str]:
    """Sources of a record that differ from the tree; empty for a record of this tree."""
    said = about(folder)
    recorded = said.get("sources") or {}
    return [path for path in {**dict.fromkeys(paths_of(said["kind"])), **recorded}
            if recorded.get(path) is None or recorded[path] != digest(root, path)]  # fmt: skip


def quoted(root: Path = ROOT) -> dict[str, list[str]]:
    """Names of the records that pages quote, with the pages."""
    found: dict[str, list[str]] = {}
    for place in PAGES:
        path = root / place
        for page in [path] if path.is_file() else sorted(path.rglob("*.md")):
            for name in dict.fromkeys(re.findall(r"benches/runs/([\w.-]+\w)", page.read_text())):
                found.setdefault(name, []).append(str(page.relative_to(root)))
    return found


def stale(pages: list[str], root: Path = ROOT) -> list[str]:
    """A line for each record that these pages (by default all) quote and whose sources differ from the tree."""
    lines = []
    for name, own in sorted(quoted(root).items()):
        shown = [page for page in own if not pages or page in pages]
        folder = root / "benches/runs" / name
        if not shown:
            continue
        if not folder.is_dir():
            lines.append(f"{name}: there is no such record; quoted by {', '.join(shown)}")
        elif older := changed(folder, root):
            lines.append(f"{name}: {', '.join(older)} changed; quoted by {', '.join(shown)}")
    return lines


def of_commit(folder: Path, root: Path = ROOT) -> dict:
    """The description of a record that only has a commit in its name."""
    kind, commit = kind_of(folder.name), folder.name.rsplit("-", 1)[-1]
    known = git(root, "rev-parse", f"{commit}^{{commit}}")
    said = {"kind": kind, "commit": known.decode().strip() if known else commit, "program": None}
    said["sources"] = digests(kind, said["commit"], root) if known else None
    if known:
        both = KINDS.get(kind, {}).get("contact")
        mirrored = git(root, "grep", "-q", MIRRORED, commit, "--", "src") is not None
        said["contact"] = both or ("mirrored flanks" if mirrored else "one line")
    return said


if __name__ == "__main__":
    # For records from other programs than scripts/record: scripts/records/sources.py benches/runs/DATE-KIND-COMMIT
    for name in sys.argv[1:]:
        (Path(name) / "about.json").write_text(json.dumps(of_commit(Path(name).resolve()), indent=1) + "\n")

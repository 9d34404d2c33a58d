"""Records know which sources they measured, and pages say where these have changed."""

import json
import os
import pathlib
import runpy
import subprocess
import sys
import types

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts/records"))

import front_page  # noqa: E402
import records  # noqa: E402
import sources  # noqa: E402

SOURCE = """//! What it does.
fn answer() -> u32 {
    // Found by search.
    42
}

#[cfg(test)]
mod tests {
    #[test]
    fn it_is_the_answer() {}
}
"""


@pytest.fixture
def tree(tmp_path):
    """A repository with the sources of a kind `verify` that has been measured, and a page that quotes the record."""

    def git(*arguments):
        who = {f"GIT_{role}_{what}": "someone@nowhere" for role in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")}
        subprocess.run(["git", *arguments], cwd=tmp_path, check=True, capture_output=True, env=os.environ | who)

    git("init")
    for path in sources.paths_of("verify"):
        file = tmp_path / path / "lib.rs" if "." not in path and path.startswith("src") else tmp_path / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(SOURCE)
    git("add", "-A")
    git("commit", "-m", "Answer")
    commit = sources.git(tmp_path, "rev-parse", "--short", "HEAD").decode().strip()
    record = tmp_path / f"benches/runs/2026-01-01-verify-{commit}"
    record.mkdir(parents=True)
    (record / "about.json").write_text(json.dumps(sources.of_commit(record, tmp_path)))
    (tmp_path / "README.md").write_text(f"[fast](benches/runs/{record.name}/summary.md), as ever\n")
    (tmp_path / "docs").mkdir()
    sources.digest.cache_clear()
    yield record
    sources.digest.cache_clear()


def stale(record, pages=()):
    sources.digest.cache_clear()
    return sources.stale(list(pages), record.parents[2])


def edit(record, path, old, new):
    file = record.parents[2] / path
    assert old in file.read_text()
    file.write_text(file.read_text().replace(old, new))


def test_a_record_of_the_tree_is_not_stale(tree):
    assert stale(tree) == []
    assert sources.about(tree)["contact"] == "one line", "no flank is mirrored in these sources"


def test_a_changed_source_makes_a_record_stale_and_names_it(tree):
    edit(tree, "src/core/lib.rs", "42", "43")
    [line] = stale(tree)
    assert line == f"{tree.name}: src/core changed; quoted by README.md"
    assert stale(tree, ["docs/measured.md"]) == [] and stale(tree, ["README.md"]) == [line]
    edit(tree, "src/core/lib.rs", "43", "42")
    assert stale(tree) == []


def test_a_new_and_a_removed_file_count(tree):
    new = tree.parents[2] / "src/gears/new.rs"
    new.write_text("fn more() {}\n")
    assert "src/gears changed" in stale(tree)[0]
    new.unlink()
    (tree.parents[2] / "src/verify/lib.rs").unlink()
    assert "src/verify changed" in stale(tree)[0]


def test_comments_blank_lines_and_unit_tests_do_not_count(tree):
    edit(tree, "src/core/lib.rs", "// Found by search.", "// Found by long search.\n")
    edit(tree, "src/core/lib.rs", "fn it_is_the_answer() {}", "fn it_is() { assert_eq!(super::answer(), 42); }")
    (tree.parents[2] / "src/core/tests.rs").write_text("fn helper() {}\n")
    assert stale(tree) == []


def test_the_program_that_measures_counts(tree):
    edit(tree, "scripts/records/verify", "42", "41")
    assert "scripts/records/verify changed" in stale(tree)[0]


def test_a_record_without_sources_is_stale_and_one_that_is_missing_is_told(tree):
    (tree / "about.json").unlink()
    assert "src/core" in stale(tree)[0]
    (tree.parents[2] / "docs/page.md").write_text("see benches/runs/2026-01-01-cycle-0000000/summary.md.\n")
    assert "2026-01-01-cycle-0000000: there is no such record; quoted by docs/page.md" in stale(tree)


def test_every_source_of_a_kind_is_there():
    for name, kind in sources.KINDS.items():
        assert sources.programs_of(name), name
        assert all((ROOT / path).exists() for path in kind["sources"]), name
        assert kind["clock"] in ("wall", "processor", "none") and kind["minutes"] > 0 and kind["about"]


def test_all_of_them_take_at_most_two_hours():
    listed = subprocess.run([ROOT / "scripts/record", "all", "--list"], capture_output=True, text=True, check=True).stdout
    minutes = int(listed.split()[0])
    assert minutes == sum(int(line.split()[1]) for line in listed.splitlines()[1:]) <= 120


def test_every_record_says_what_it_measured():
    for folder in records.RUNS.iterdir():
        said = sources.about(folder)
        assert (folder / "about.json").exists() and said["kind"] == sources.kind_of(folder.name)
        assert said["commit"].startswith(folder.name.rsplit("-", 1)[-1][:7])


def test_marks_follow_the_sources_and_make_no_page_wrong(monkeypatch, tmp_path):
    page = tmp_path / "page.md"
    page.write_text("a\n<!-- speed: begin -->\nold\n<!-- speed: end -->\nb\n")
    monkeypatch.setattr(records, "ROOT", tmp_path)
    block = {"speed": lambda: [f"[fast](x){records.STALE}"]}
    with pytest.raises(SystemExit, match=r"figures of page\.md"):
        records.write_blocks("page.md", block, ["--check"])
    records.write_blocks("page.md", block, [])
    assert page.read_text() == f"a\n<!-- speed: begin -->\n[fast](x){records.STALE}\n<!-- speed: end -->\nb\n"
    records.write_blocks("page.md", {"speed": lambda: ["[fast](x)"]}, ["--check"])
    with pytest.raises(SystemExit):
        records.write_blocks("page.md", {"other": lambda: []}, [])


def test_every_number_on_the_front_page_is_a_listed_figure():
    """Numbers of the part of README.md that tells speed and accuracy stand in the list of figures, or in its texts."""
    listed = " ".join(text for _, _, text in front_page.figures())
    text = (ROOT / "README.md").read_text()
    # Outside of the written part, nothing is said of time or error.
    before, rest = text.split("<!-- speed: begin -->")
    written, after = rest.split("<!-- speed: end -->")
    for words in (before, after):
        assert not [word for word in ("seconds", " µs", "minutes", "times as", "faster") if word in words]
    for _, _, figure in front_page.figures():
        assert figure in written, figure
    cells = [cell.strip() for line in written.splitlines() if line.startswith("|") for cell in line.split("|")[2:-1]]
    assert all(cell in listed for cell in cells if cell[:1].isdigit() and "modes" not in cell)


@pytest.fixture
def command(monkeypatch):
    """The names of scripts/record; nothing is measured."""
    names = runpy.run_path(str(ROOT / "scripts/record"), run_name="record")
    started = []
    monkeypatch.setitem(names["measure"].__globals__, "build", lambda kind: None)
    monkeypatch.setitem(names["measure"].__globals__, "commit_of", lambda program: None)
    stub = types.SimpleNamespace(run=lambda command, **_: started.append(command) or subprocess.CompletedProcess(command, 0))
    monkeypatch.setitem(names["measure"].__globals__, "subprocess", stub)
    return names, started


def test_wall_times_want_a_quiet_machine(command, monkeypatch, capsys):
    names, started = command
    monkeypatch.setitem(names["measure"].__globals__, "busy", lambda: 0.3)
    monkeypatch.delenv("ATLAS", raising=False)
    assert names["measure"]("scaling", [], noisy=False) == 1
    assert "30% of the processors are at work" in capsys.readouterr().err
    assert not any("record_scaling" in str(command) for command in started)
    for kind, noisy in (("scaling", True), ("settling", False)):
        assert names["measure"](kind, [], noisy) == 0
        assert any(f"record_{kind}.py" in str(command) for command in started)


def test_a_program_of_other_sources_is_refused(command, monkeypatch, capsys):
    names, _ = command
    monkeypatch.setitem(names["measure"].__globals__, "busy", lambda: 0.0)
    monkeypatch.setenv("ATLAS", "/bin/true")
    assert names["measure"]("settling", [], noisy=False) == 1
    assert "whose sources are not those of this tree" in capsys.readouterr().err


def test_processors_at_work_are_seen(command):
    names, _ = command
    assert 0 <= names["busy"]() <= 1

"""docs/gallery.md says how each of its pictures is made, and shows all pictures that there are."""

import sys
from pathlib import Path

import pytest

from program import ROOT

sys.path.insert(0, str(ROOT / "scripts/records"))
from make_gallery import PAGE, PICTURES, sections  # noqa: E402


def test_every_picture_is_in_the_gallery_with_its_commands():
    found = sections(PAGE.read_text())
    kept = {path.name for path in PICTURES.iterdir() if path.suffix in (".svg", ".png")}
    assert sorted(section.picture for section in found) == sorted(kept)
    for section in found:
        assert Path(section.written).suffix == Path(section.picture).suffix, section.picture
        for command in section.commands:
            named = [word for word in command.split() if word.startswith(("manifests/", "docs/"))]
            assert all((ROOT / word).is_file() for word in named), command


@pytest.mark.parametrize(
    "page",
    [
        "## No picture\n\n```sh\natlas run m.toml    # → a.svg\n```\n",
        "## Two blocks\n\n```sh\natlas a    # → a.svg\n```\n\n```sh\natlas b    # → b.svg\n```\n\n![a](pictures/a.svg)\n",
        "## No file\n\n```sh\natlas run m.toml\n```\n\n![a](pictures/a.svg)\n",
    ],
)
def test_a_section_that_does_not_say_how_is_refused(page):
    with pytest.raises(SystemExit, match=page.splitlines()[0].removeprefix("## ")):
        sections(page)

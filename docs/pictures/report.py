"""The picture of docs/report.md: a page of `atlas report` in a window of 1200 by 940 pixels.

    .venv/bin/python docs/pictures/report.py results/small/report.html
"""

import pathlib
import shutil
import sys

from playwright.sync_api import sync_playwright

HERE = pathlib.Path(__file__).parent


def main(page):
    browsers = map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))
    browser = next(filter(None, browsers), None)
    if browser is None:
        sys.exit("report.py: no Chromium here; scripts/setup --browser installs it")
    with sync_playwright() as started:
        chromium = started.chromium.launch(executable_path=browser, args=["--no-sandbox", "--disable-gpu"])
        shown = chromium.new_page(viewport={"width": 1200, "height": 940})
        shown.goto(pathlib.Path(page).resolve().as_uri())
        shown.wait_for_selector("#statistics td")
        shown.wait_for_selector("#pictures canvas")
        shown.screenshot(path=HERE / "report.png")
        chromium.close()


if __name__ == "__main__":
    main(*sys.argv[1:])

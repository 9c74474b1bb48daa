"""Rules of accessibility on each page, by axe-core in a browser.

Looked at are the explorer, the report of the paper's study and the site, as far as they are there
(`make reproduce docs`): wide and light, narrow and dark, each as it opens and with everything
unfolded. A page that can be scrolled sideways is a violation, too.
"""

import sys
from argparse import ArgumentParser
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from validation.browser import CHROMIUM, Page, chromium
from vibrissa.explorer.page import page as explorer

ROOT = Path(__file__).parents[1]
WINDOWS: tuple[dict[str, Any], ...] = (
    {"width": 1200, "prefers_color_scheme": "light"},
    {"width": 390, "prefers_color_scheme": "dark"},
)
FOLDED = "[...document.querySelectorAll('details:not([open])')]"
UNFOLD = f"{FOLDED}.forEach(part => {{ part.open = true; }})"
# What fades in or out has another contrast on its way.
SETTLED = "Promise.allSettled(document.getAnimations().map(one => one.finished))"
# This axe-core is older than ARIA 1.3, which has one attribute more.
NEWER = """axe.configure(
  {standards: {ariaAttrs: {"aria-description": {type: "string", global: true}}}})"""
VIOLATIONS = """axe.run({resultTypes: ["violations"]}).then(found => found.violations.map(
  one => `${one.id}: ${one.nodes.length} places, such as ${one.nodes[0].html.slice(0, 120)}`))"""
WIDTH = "document.documentElement.scrollWidth"


class Look(NamedTuple):
    """A page in a window, and what is wrong with it there."""

    name: str
    wrong: list[str]


def violations(page: Page, width: int) -> list[str]:
    """List the violations of the page as it is shown now in a window of some width."""
    page.evaluate(f"{SETTLED}.then(() => 0)")
    wrong: list[str] = page.evaluate(VIOLATIONS)
    wider = page.evaluate(WIDTH) > width
    return [*wrong, "the page is wider than its window"] if wider else wrong


def looks(paths: list[Path], folder: Path) -> Iterator[Look]:
    """Open each page in each window, folded and unfolded; yield what is wrong with it."""
    axe = files("axe_core_python").joinpath("axe.min.js").read_text(encoding="utf-8")
    with chromium(folder) as page:
        for path in paths:
            for window in WINDOWS:
                page.open(path.as_uri(), **window)
                page.evaluate(f"{axe}; {NEWER}; 0")
                name = f"{path.name}, {window['width']} px, {window['prefers_color_scheme']}"
                yield Look(name, violations(page, window["width"]))
                if page.evaluate(f"{FOLDED}.length"):
                    page.evaluate(UNFOLD)
                    yield Look(f"{name}, unfolded", violations(page, window["width"]))


def main() -> int:
    """Print what is wrong; return 1 if anything is."""
    parser = ArgumentParser("python -m validation accessibility", description=__doc__)
    parser.add_argument("pages", nargs="*", type=Path, help="files to look at in place of all")
    given = parser.parse_args().pages
    if CHROMIUM is None:
        sys.exit("there is no Chromium to open the pages with; on Debian: apt install chromium")
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        alone = Path(folder, "explorer.html")
        alone.write_text(explorer(), encoding="utf-8")
        made = [*ROOT.glob("results/paper/report.html"), *sorted(ROOT.glob("build/site/*.html"))]
        paths = given or [alone, *made]
        count, bad = 0, 0
        for look in looks([path.resolve() for path in paths], Path(folder, "profile")):
            count += 1
            for line in look.wrong:
                bad += 1
                print(f"{look.name}: {line}", flush=True)
    print(f"{len(paths)} pages, looked at in {count} ways: {bad} violations")
    return int(bad > 0)

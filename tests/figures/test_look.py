"""How each kind of figure looks: pages, axes, lines, marks and words do not change unnoticed.

What a figure shows is tested in test_draw.py and test_series.py, with tables of its own. Here are
the figures that those draw of made-up rows, described in words.
"""

from pathlib import Path

import pytest
import yaml

from figure_rows import ROWS, drawn
from looks import figure_described
from vibrissa.figures import style

LOOK = Path(__file__).with_name("look.yaml")
KNOWN = yaml.safe_load(LOOK.read_text(encoding="utf-8"))
# Few series with a legend, and many with a colour bar.
COUNTS = (3, 12)


@pytest.fixture(scope="module")
def now(tmp_path_factory):
    """The looks as they are now, and a file for them."""
    return dict(KNOWN), tmp_path_factory.mktemp("look") / LOOK.name


def compared(now, name, figure):
    looks, new = now
    looks[name] = figure_described(figure)
    if looks[name] != KNOWN.get(name):
        new.write_text(yaml.safe_dump(looks, allow_unicode=True, sort_keys=False, width=1000))
        print(f"If figures were meant to change: look at them, and copy {new} over {LOOK}.")
    assert looks[name] == KNOWN.get(name)


@pytest.mark.parametrize("kind", ROWS)
@pytest.mark.parametrize("count", COUNTS)
def test_a_figure_looks_as_it_did(kind, count, now):
    compared(now, f"{kind} {count}", drawn(kind, count))


@pytest.mark.parametrize("count", [7, 21])
def test_maps_of_many_heights_look_as_they_did(count, now):
    compared(now, f"regimes {count}", drawn("regimes", count))


def test_a_figure_that_says_why_there_is_none_looks_as_it_did(now):
    with style.applied():
        compared(now, "message", style.message("failed: no luck"))

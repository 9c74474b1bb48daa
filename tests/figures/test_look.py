"""How each kind of figure looks: pages, axes, lines, marks and words do not change unnoticed.

What a figure shows is tested in test_draw.py and test_series.py, with tables of its own. Here are
the figures that those draw of made-up rows, described in words.
"""

import pytest

from figure_rows import ROWS, drawn
from known import Known
from looks import figure_described
from vibrissa.figures import style

KNOWN = Known(__file__)
# Few series with a legend, and many with a colour bar.
COUNTS = (3, 12)


@pytest.mark.parametrize("kind", ROWS)
@pytest.mark.parametrize("count", COUNTS)
def test_a_figure_looks_as_it_did(kind, count):
    KNOWN.check(f"{kind} {count}", figure_described(drawn(kind, count)))


@pytest.mark.parametrize("count", [7, 21])
def test_maps_of_many_heights_look_as_they_did(count):
    KNOWN.check(f"regimes {count}", figure_described(drawn("regimes", count)))


def test_a_figure_that_says_why_there_is_none_looks_as_it_did():
    with style.applied():
        KNOWN.check("message", figure_described(style.message("failed: no luck")))

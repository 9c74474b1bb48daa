"""The check of accessibility finds faults: where the page opens, and where it is folded."""

import pytest

from validation.accessibility import looks
from validation.browser import CHROMIUM

pytest.importorskip("axe_core_python")
pytestmark = [
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium to open pages with"),
    pytest.mark.slow,
]
PAGE = """<!DOCTYPE html><html lang="en"><title>A page</title>
<meta name="viewport" content="width=device-width"><main><h1>A page</h1>
<select aria-label="one" aria-description="of several"><option>1</select>{}</main></html>"""


@pytest.mark.parametrize(
    ("part", "expected"),
    [
        ("<p>well", set()),
        ('<img src="none">', {"image-alt"}),
        ('<details><summary>More</summary><img src="none"></details>', {"image-alt"}),
        ('<p style="width: 500px">wide', {"the page is wider than its window"}),
    ],
)
def test_what_is_wrong_with_a_page(tmp_path, part, expected):
    path = tmp_path / "page.html"
    path.write_text(PAGE.format(part))
    found = [line for look in looks([path], tmp_path / "profile") for line in look.wrong]
    assert {line.partition(":")[0] for line in found} == expected

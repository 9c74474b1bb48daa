"""Places in a study file, and the words for them."""

import pytest

from vibrissa.study.mistakes import SHOWN_CHARACTERS, at, spell_location, spell_value

FILE = {"grids": {"main": {"theta": [1, 2]}}, "study": "mine"}


@pytest.mark.parametrize(
    ("location", "found"),
    [
        ((), FILE),
        (("study",), "mine"),
        (("grids", "main", "theta", 1), 2),
        (("grids", "main", "theta", 2), None),
        (("grids", "main", "theta", "1"), None),
        (("grids", "other"), None),
        (("study", 0), None),
        (("study", "name"), None),
    ],
)
def test_what_stands_at_a_place(location, found):
    assert at(FILE, location) == found


@pytest.mark.parametrize(
    ("location", "text"),
    [
        ((), ""),
        (("study",), "study"),
        (("grids", "main", "theta", 1), "grids.main.theta[1]"),
        ((0, "a"), "[0].a"),
        (("a\nb",), repr("a\nb")),
    ],
)
def test_a_place_in_words(location, text):
    assert spell_location(location) == text


def test_a_long_value_is_cut_where_it_is_longer_than_a_line_shows():
    # With its two quotation marks.
    assert spell_value("x" * (SHOWN_CHARACTERS - 2)) == f"'{'x' * (SHOWN_CHARACTERS - 2)}'"
    assert spell_value("x" * (SHOWN_CHARACTERS - 1)) == f"'{'x' * (SHOWN_CHARACTERS - 1)}..."

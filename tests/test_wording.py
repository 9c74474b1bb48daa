"""Text for people."""

from vibrissa.wording import markdown_table


def test_a_table_has_its_bars_escaped_and_its_gaps_marked():
    assert markdown_table(("a", "b"), [("x|y", ""), ("1", "2")]).splitlines() == [
        "| a | b |",
        "| --- | --- |",
        "| x\\|y | – |",
        "| 1 | 2 |",
    ]

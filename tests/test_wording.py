"""Text for people."""

from vibrissa.wording import counted, markdown_table


def test_things_are_counted():
    assert [counted(n, "row") for n in (0, 1, 2000)] == ["0 rows", "1 row", "2,000 rows"]


def test_a_table_has_its_bars_escaped_and_its_gaps_marked():
    assert markdown_table(("a", "b"), [("x|y", ""), ("1", "2")]).splitlines() == [
        "| a | b |",
        "| --- | --- |",
        "| x\\|y | – |",
        "| 1 | 2 |",
    ]

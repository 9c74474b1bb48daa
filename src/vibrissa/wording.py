"""Formatting of text: counts with their nouns, names of figures, tables in Markdown."""

import re
from collections.abc import Iterable, Sequence

NOTHING = "–"


def counted(number: int, noun: str) -> str:
    """Format a count with its noun: ``1 row``, ``2,000 rows``.

    Examples
    --------
    >>> print(counted(0, "row"), counted(1, "row"), counted(2000, "row"))
    0 rows 1 row 2,000 rows
    """
    return f"{number:,} {noun}{'s' * (number != 1)}"


def see_page(title: str) -> str:
    """Refer to a page of the documentation by its title."""
    return f'see the page "{title}" of the documentation'


def figure_name(key: str) -> str:
    """Name a figure by its key in a study file.

    Examples
    --------
    >>> print(figure_name("fig4a"), figure_name("lock_law"), sep=", ")
    Figure 4a, Lock law
    """
    if number := re.fullmatch(r"fig(?:ure)?[_-]?(\d+\w?)", key):
        return f"Figure {number[1]}"
    words = re.sub("[_-]+", " ", key)
    return words[:1].upper() + words[1:]


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Write a table in Markdown, with a dash in empty cells.

    Examples
    --------
    >>> print(markdown_table(["a", "b"], [["1", ""]]))
    | a | b |
    | --- | --- |
    | 1 | – |
    """
    cells = [head, ["---"] * len(head), *rows]
    return "\n".join(
        f"| {' | '.join((cell or NOTHING).replace('|', chr(92) + '|') for cell in row)} |"
        for row in cells
    )

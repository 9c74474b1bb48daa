"""Text for people: how many there are of something, and tables in Markdown."""

from collections.abc import Iterable, Sequence

NOTHING = "–"


def counted(number: int, noun: str) -> str:
    """Say how many there are of something, such as ``1 row`` or ``2,000 rows``.

    Examples
    --------
    >>> print(counted(1, "row"), counted(2000, "row"))
    1 row 2,000 rows
    """
    return f"{number:,} {noun}{'s' * (number != 1)}"


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

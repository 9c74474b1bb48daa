"""Two results folders side by side, told on the screen, in Markdown and in a figure."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from vibrissa.checking.differences import Change, Difference, Problem
from vibrissa.checking.side_by_side import Moved, SideBySide
from vibrissa.figures import style
from vibrissa.files import write_atomically
from vibrissa.wording import NOTHING, counted, markdown_table

PAGE, FIGURES = "comparison.md", ("changes.png", "changes.svg")
# Keys of the study file that the screen shows.
MOST_KEYS = 10
# A row stands in one table alone.
ALONE = {Problem.MISSING: "in A alone", Problem.EXTRA: "in B alone"}


def lines(found: SideBySide) -> Iterator[str]:
    """Say what differs, a line each.

    Parameters
    ----------
    found : SideBySide

    Yields
    ------
    str
    """
    made = ["; ".join(dict.fromkeys(origin.programs.values())) for origin in found.origins]
    if made[0] != made[1]:
        yield f"made by: {made[0]} -> {made[1]}"
    changes = list(found.study_changes.items())
    for key, (a, b) in changes[:MOST_KEYS]:
        yield f"study file: {key}: {a or 'nothing'} -> {b or 'nothing'}"
    if more := changes[MOST_KEYS:]:
        yield f"study file: {counted(len(more), 'more key')}; {PAGE} has all of them"
    for name, (of_a, of_b) in found.rows.items():
        if not (of_a and of_b):
            where = "A" if of_a else "B"
            yield f"{name}: the table is in {where} alone, {counted(of_a or of_b, 'row')}"
    for difference in found.differences:
        yield _alone(difference) if difference.problem in ALONE else difference.text
    yield found.verdict


def _alone(difference: Difference) -> str:
    rows = f"{counted(difference.rows, 'row')} {ALONE[difference.problem]}"
    return f"{difference.table}: {rows}: {_examples(difference)}"


def _examples(difference: Difference) -> str:
    rows = "; ".join(map(_keys, difference.examples))
    return rows + ("; ..." if difference.rows > len(difference.examples) else "")


def _keys(row: Mapping[str, str]) -> str:
    return ", ".join(f"{key} {value}" for key, value in row.items())


def write(found: SideBySide, folder: Path) -> Path:
    """Write a page in Markdown and, where numbers moved, a figure beside it.

    Parameters
    ----------
    found : SideBySide
    folder : Path
        Made if it is not there.

    Returns
    -------
    Path
        The page.
    """
    folder.mkdir(parents=True, exist_ok=True)
    figures = [folder / name for name in FIGURES]
    numbers = [one for one in found.moved if one.numbers]
    if numbers:
        draw(numbers, figures)
    else:
        for path in figures:
            path.unlink(missing_ok=True)  # of an earlier comparison
    page = folder / PAGE
    with write_atomically(page) as temporary:
        temporary.write_text(markdown(found), encoding="utf-8")
    return page


def markdown(found: SideBySide) -> str:
    """Tell in Markdown what differs.

    Parameters
    ----------
    found : SideBySide

    Returns
    -------
    str
    """
    a, b = found.folders
    parts = [f"# {a.name} and {b.name}", found.verdict, "## Tables", _tables(found)]
    if changes := found.study_changes:
        rows = [(key, *values) for key, values in changes.items()]
        parts += ["## Study file", markdown_table(("key", "A", "B"), rows)]
    if rest := [one for one in found.differences if one.problem is not Problem.MOVED]:
        alone = [
            (one.table, ALONE.get(one.problem, one.problem), str(one.rows), _examples(one))
            for one in rest
        ]
        parts += ["## Rows", markdown_table(("table", "what", "rows", "which"), alone)]
    if found.moved:
        parts += ["## Columns that moved", _columns(found)]
    if worst := found.worst():
        head = ("table", "where", "column", "A", "B", "relative change")
        largest = [
            (one.table, _keys(at.row), one.column, at.before, at.after, _size(at))
            for one, at in worst
        ]
        parts += [
            f"![relative changes of each column]({FIGURES[0]})",
            "Each box holds the middle half of the rows that moved, its line is the median, and "
            "the whiskers end at the smallest and the largest change.",
            "## Largest relative changes",
            markdown_table(head, largest),
        ]
    return "\n\n".join(parts) + "\n"


def _tables(found: SideBySide) -> str:
    programs_a, programs_b = (origin.programs for origin in found.origins)
    rows = []
    for name, (of_a, of_b) in found.rows.items():
        # The states alpha = 0 of the curves are read from the table of grid points.
        file = "stiction" if name == "curves" else name
        made = (programs_a.get(file, NOTHING), programs_b.get(file, NOTHING))
        rows.append((name, str(of_a), str(of_b), *made))
    head = ("table", f"rows of A, {found.folders[0]}", f"rows of B, {found.folders[1]}")
    return markdown_table((*head, "A made by", "B made by"), rows)


def _columns(found: SideBySide) -> str:
    moved = {(one.table, one.column): one for one in found.moved}
    rows = []
    for one in found.differences:
        if one.problem is Problem.MOVED:
            words = moved[one.table, one.column].outcomes
            rows.append(
                (
                    f"{one.table}.{one.column}",
                    f"{one.rows} of {one.of}",
                    _where(one.absolute) or "; ".join(words),
                    _where(one.relative),
                )
            )
    return markdown_table(("column", "rows", "largest change", "largest relative change"), rows)


def _where(change: Change | None) -> str:
    return "" if change is None else f"{_size(change)} {change}"


def _size(change: Change) -> str:
    return NOTHING if change.size is None else f"{change.size:.2g}"


def draw(moved: Sequence[Moved], paths: Sequence[Path]) -> None:
    """Draw the relative changes of each column as a box: median, middle half, extremes.

    Parameters
    ----------
    moved : sequence of Moved
        Columns of numbers.
    paths : sequence of Path
        Files to be written, as `style.save`.
    """
    with style.applied():
        figure, axes = style.axes(1.1 + 0.24 * len(moved))
        parts = ("whislo", "q1", "med", "q3", "whishi")
        axes.bxp(
            [
                {"label": f"{one.table}.{one.column}", **dict(zip(parts, one.shares, strict=True))}
                for one in moved
            ],
            orientation="horizontal",
            widths=0.5,
            showfliers=False,
            boxprops={"color": style.COLORS[0]},
            whiskerprops={"color": style.COLORS[0]},
            capprops={"color": style.COLORS[0]},
            medianprops={"color": style.COLORS[1]},
        )
        axes.set_xscale("log")
        axes.invert_yaxis()
        axes.set_xlabel("relative change, of the rows that moved")
        axes.xaxis.grid(True, linewidth=0.4, color="#cccccc")
        for place, one in enumerate(moved, start=1):
            axes.annotate(
                f"{one.numbers:,}",
                (1.0, place),
                xycoords=("axes fraction", "data"),
                xytext=(4, 0),
                textcoords="offset points",
                va="center",
                fontsize=8,
            )
        axes.set_title("number of rows", loc="right", fontsize=8)
    style.save(figure, paths)

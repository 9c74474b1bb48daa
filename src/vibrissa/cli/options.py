"""Options that several commands have, and what they mean."""

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vibrissa.errors import ArgumentError
from vibrissa.extras import require
from vibrissa.files import write_atomically
from vibrissa.outcomes import Contact, RodSection
from vibrissa.sensor.series import STANDARD, check_ending
from vibrissa.sensor.transducer import PRESETS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURES = (".pdf", ".svg", ".png")
# Progress is shown for work that takes longer (s).
PATIENCE = 2.0

# How a command is set up in its own file; `vibrissa.cli.app` puts the commands together.
ALONE: dict[str, Any] = {"add_completion": False, "rich_markup_mode": "markdown"}

Modulus = Annotated[str | None, typer.Option(help="Young's modulus of the rod: '210 GPa'.")]
_TOUCH = typer.Option(
    "--contact",
    help="How the rod may touch the surface. point: with its tip alone; line: it may lie flat "
    "along the surface, where it would otherwise pass through it.",
    show_default=Contact.POINT,
)
Touch = Annotated[Contact, _TOUCH]
# What a rod file may say instead.
MaybeTouch = Annotated[Contact | None, _TOUCH]
MaybeSection = Annotated[
    RodSection | None,
    typer.Option(
        "--section",
        help="What the rod's section lets it do. round: once locked it swings aside, out of its "
        "plane; planar: a strip or a guided rod stays in it.",
        show_default=RodSection.ROUND,
    ),
]
Transducer = Annotated[
    str | None,
    typer.Option("--transducer", help=f"Transducer under the clamp: {', '.join(PRESETS)}."),
]
Picture = Annotated[
    Path | None, typer.Option(help="Draw the result, too: a .pdf, .svg or .png file.")
]
Out = Annotated[
    Path,
    typer.Option("--output", "-o", help="Table to write: .csv or .parquet; - for standard output."),
]
AlsoOut = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        help="Write the result as a table, too: .csv or .parquet; - for standard output.",
    ),
]


def check_files(output: Path | None, picture: Path | None, *others: str) -> None:
    """Refuse files that cannot be written, before anything is computed.

    Parameters
    ----------
    output : Path or None
        A table; its ending may also be one of the others.
    picture : Path or None
    *others : str
    """
    if output is not None:
        check_ending(output, *others)
    if picture is None:
        return
    if picture.suffix.lower() not in PICTURES:
        raise ArgumentError(f"{picture}: the ending must be one of {', '.join(PICTURES)}")
    if not picture.parent.is_dir():
        raise ArgumentError(f"{picture}: there is no folder {picture.parent}")
    require("plots", "matplotlib")


def check_not_read(output: Path | None, *read: Path | str | None) -> None:
    """Refuse to write over a file that is read; standard input and output are two."""
    if output is None or output == STANDARD:
        return
    if output.resolve() in [Path(file).resolve() for file in read if file is not None]:
        raise ArgumentError(f"{output} is a file that is read: write another one")


def say(text: object, output: Path | None) -> None:
    """Say something on the screen, and not into a table that goes to standard output."""
    typer.echo(text, err=output == STANDARD)


def save_picture(figure: "Figure", picture: Path) -> None:
    """Write a figure as a whole."""
    with write_atomically(picture) as temporary:
        figure.savefig(temporary)


def progress_bars() -> Callable[[str, int, int], None]:
    """Show a progress bar for each kind of work, once it has taken longer than `PATIENCE`."""
    start = time.monotonic()
    bars: dict[str, Any] = {}

    def tell(what: str, done: int, total: int) -> None:
        nonlocal start
        if what not in bars:
            start = time.monotonic()
            bars[what] = typer.progressbar(length=total, label=what, file=sys.stderr)
        bar = bars[what]
        if time.monotonic() - start > PATIENCE:
            bar.update(done - bar.pos)
            if done >= total:
                bar.render_finish()

    return tell

"""Options that several commands have, and what they do."""

import os
import sys
import time
from collections.abc import Callable, Sequence
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import Annotated, Any

import typer

from vibrissa.errors import ArgumentError
from vibrissa.extras import require
from vibrissa.files import write_atomically
from vibrissa.sensor.series import STANDARD, as_json, check_ending, write

PICTURES = (".pdf", ".svg", ".png")
# Progress is shown for work that takes longer (s).
PATIENCE = 2.0

OUTPUT = "Output"


def option(text: str, metavar: str, panel: str, *names: str, **more: Any) -> Any:
    """Describe an option: its meaning, its values, and its panel in the help."""
    return typer.Option(*names, help=text, metavar=metavar or None, rich_help_panel=panel, **more)


_WRITTEN = ("--output", "-o")
Out = Annotated[
    Path,
    option("Table to write: .csv or .parquet; - for standard output.", "<file>", OUTPUT, *_WRITTEN),
]
MaybeOut = Annotated[
    Path | None,
    option(
        "Write the result as a table: .csv or .parquet; - for standard output.",
        *("<file>", OUTPUT, *_WRITTEN),
    ),
]
Picture = Annotated[
    Path | None, option("Draw the result: .pdf, .svg or .png.", "<file>", OUTPUT, "--picture")
]
Json = Annotated[bool, option("Print the result as JSON, and nothing else.", "", OUTPUT, "--json")]


def reading_options(
    parameter: str, options: Sequence[Parameter], read: Callable[..., Any], *endings: str
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command options in place of one parameter, whose value is read from them.

    Files are checked before anything is computed; an output may have one of further `endings`.
    """

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        own = dict(signature(command).parameters)
        del own[parameter]

        @wraps(command)
        def run(**values: Any) -> None:
            files = {name: values.get(name) for name in ("output", "picture")}
            check_files(files["output"], files["picture"], *endings)
            others = [value for name, value in values.items() if name not in files]
            check_not_read(list(files.values()), others)
            value = read(**{option.name: values.pop(option.name) for option in options})
            command(**{parameter: value}, **values)

        # Typer reads the options of a command from its signature and its annotations.
        every = [one.replace(kind=Parameter.KEYWORD_ONLY) for one in (*own.values(), *options)]
        run.__dict__["__signature__"] = Signature(every)
        run.__annotations__ = {one.name: one.annotation for one in every}
        return run

    return decorate


def check_files(output: Path | None, picture: Path | None, *endings: str) -> None:
    """Refuse files that cannot be written, before anything is computed.

    Parameters
    ----------
    output : Path or None
        A table; its ending may also be one of `endings`.
    picture : Path or None
    *endings : str
    """
    if output is not None:
        check_ending(output, *endings)
    if picture is not None:
        if picture.suffix.lower() not in PICTURES:
            raise ArgumentError(f"{picture}: the ending must be one of {', '.join(PICTURES)}")
        require("plots", "matplotlib")
    for file in (output, picture):
        if file is None or file == STANDARD:
            continue
        if file.is_dir():
            raise ArgumentError(f"{file} is a folder: write to another name")
        if not file.parent.is_dir():
            raise ArgumentError(f"{file}: there is no folder {file.parent}")
        if not os.access(file.parent, os.W_OK):
            raise ArgumentError(f"{file}: no permission to write to the folder {file.parent}")


def check_not_read(written: Sequence[Path | None], given: Sequence[Any]) -> None:
    """Refuse to write over a file that is read; standard input and output are two."""
    read = {Path(value).resolve() for value in given if isinstance(value, Path | str)}
    for file in written:
        if file is not None and file != STANDARD and file.resolve() in read:
            raise ArgumentError(f"{file} is an input: give the output another name")


def hand_out(found: Any, output: Path | None, picture: Path | None, json: bool = False) -> None:
    """Write a result as a table, a picture and JSON, each if it was requested."""
    if json:
        typer.echo(as_json(found.columns()))
    if output is not None:
        write(output, found.columns())
    if picture is not None:
        with write_atomically(picture) as temporary:
            found.plot().savefig(temporary)


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

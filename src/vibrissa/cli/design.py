"""``vibrissa design``: the rod that measures friction best."""

from pathlib import Path
from typing import Annotated

import typer

from vibrissa.cli.options import (
    ALONE,
    Picture,
    check_files,
    progress_bars,
    save_picture,
    say,
)
from vibrissa.cli.requirements import takes_requirements
from vibrissa.design import Design, DesignStatus, Requirements
from vibrissa.design import design as find_design
from vibrissa.sensor import series
from vibrissa.sensor.given import rod_file

app = typer.Typer(**ALONE)

# Ending of a rod file.
ROD_FILE = ".toml"
Written = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        help="Write the result, too: as a table, .csv or .parquet, or as a rod file, .toml, that "
        "the other commands read with --rod.",
    ),
]


@app.command(
    epilog="Examples: `vibrissa design --material music-wire --transducer nano17-si-12-0.12 --step "
    "'50 um' --mu0 '0.2 to 0.4'`; a rod that is given is checked: `vibrissa design --material "
    "steel-s235 --diameter '5 mm' --length '100 mm' --theta 2 --eta 0.85 --transducer "
    "nano17-si-12-0.12 --step '50 um' --mu0 '0.2 to 0.4'`",
)
@takes_requirements
def design(requirements: Requirements, output: Written = None, picture: Picture = None) -> None:
    """Find the rod that measures friction best, and its active constraints.

    Chooses taper, height, diameter and length among rods that can be bought, cut and turned. The
    best rod has the smallest uncertainty of mu0 from one period of sticking, random and by the
    tolerances, at that mu0 of the range where it is largest. It must not yield, its tip must not
    lock, a period must have enough steps, and the forces must leave a margin of the transducer's
    range. With one value each for `--theta`, `--eta`, `--diameter` and `--length` that rod is
    checked. If no rod meets all constraints, the one that violates them least is shown, and the
    exit code is 1.
    """
    check_files(output, picture, ROD_FILE)
    found = find_design(requirements, progress_bars())
    say(found, output)
    if output is not None:
        _write(found, output)
    if picture is not None:
        save_picture(found.plot(), picture)
    if found.status is DesignStatus.NONE:
        raise typer.Exit(1)


def _write(found: Design, output: Path) -> None:
    """Write the result as a table, or the rod that was found as a rod file."""
    if output.suffix.lower() != ROD_FILE:
        series.write(output, found.columns())
    elif found.status is DesignStatus.FOUND:
        rod_file.write(output, found.rod_file(), f"vibrissa design: {found.message}")
    else:
        typer.echo(f"{output} is not written: the rod violates constraints", err=True)

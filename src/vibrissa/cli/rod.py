"""``vibrissa rod``: a set-up from measured diameters and moduli of a real rod."""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from vibrissa.cli.app import HELP
from vibrissa.cli.options import option
from vibrissa.cli.screen import say
from vibrissa.quantities.keys import write_keys
from vibrissa.quantities.series import check_ending
from vibrissa.sensor.measured import DEGREE, TOLERANCE, measured_rod

EXAMPLE = "Example: `vibrissa rod whisker.csv -o whisker.toml --picture whisker.svg`"
# Number of points of the drawn fit.
POINTS = 101


def run(
    table: Annotated[
        Path,
        typer.Argument(
            help="Table (.csv or .parquet) with the columns position, diameter and modulus, from "
            "clamp to tip, with units in the titles: 'diameter [mm]'."
        ),
    ],
    output: Annotated[
        Path | None, option("Set-up file (.toml) to write.", "Output", "--output", "-o")
    ] = None,
    picture: Annotated[
        Path | None, option("Picture of the fit: .svg, .pdf or .png.", "Output", "--picture")
    ] = None,
    degree: Annotated[
        int, option("Number of coefficients of the stiffness along the rod.", "Fit", "--degree")
    ] = DEGREE,
    tolerance: Annotated[
        float,
        option("Largest relative difference of a diameter from a cone.", "Fit", "--tolerance"),
    ] = TOLERANCE,
) -> None:
    """Fit taper and stiffness to a table of diameters and moduli of a real rod.

    The stiffness is E·d⁴ as measured. The fit has the diameters of a cone, and a polynomial of the
    position for the rest: the key stiffening. The report has the errors of both, and whether the
    rod is a cone within the tolerance. `-o rod.toml` writes a set-up file for the other commands.
    """
    if output is not None:
        check_ending(output, (".toml",))
    if picture is not None:
        check_ending(picture, (".svg", ".pdf", ".png"))
    found = measured_rod(table, degree, tolerance)
    for line in found.report():
        say(line)
    if output is not None:
        write_keys(output, found.keys(), f"vibrissa rod {found.source}")
    if picture is not None:
        from vibrissa.figures import measured, style

        s = np.linspace(0.0, 1.0, POINTS)
        figure = measured.fit(
            1e3 * found.position,
            (1e3 * found.diameter, 1e6 * found.measured_stiffness),
            (1e3 * found.cone(s), 1e6 * found.stiffness(s)),
        )
        style.save(figure, [picture], f"rod {found.source}")


_app = typer.Typer(add_completion=False, rich_markup_mode="markdown")
_app.command("rod", context_settings=HELP, epilog=EXAMPLE)(run)
rod = typer.main.get_command(_app)

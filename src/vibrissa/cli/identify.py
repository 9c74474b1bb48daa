"""``vibrissa identify``: from a measured time series to friction."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from vibrissa import sensor
from vibrissa.cli.options import SETUP, command, hand_out, option
from vibrissa.cli.warnings import density_of, material_of, warn, with_modulus
from vibrissa.extras import require
from vibrissa.files import write_atomically
from vibrissa.outcomes import Method
from vibrissa.quantities.series import ENDINGS, check_ending, write
from vibrissa.quantities.units import Measured
from vibrissa.sensor import Grade, Identification, PeriodStatus, Setup
from vibrissa.sensor.setup import TOLERANCES
from vibrissa.wording import counted, see_page

SIGNALS = "Signals"
# Ending of a file that becomes a page for people, not a table.
PAGE = ".html"
PICTURES = (".png", ".svg", ".pdf")
PANELS = {**SETUP, SIGNALS: ("transducer", "noise", TOLERANCES)}
EXAMPLE = "Example: `vibrissa identify scan.csv --rod setup.toml -o friction.csv`"


@command(PANELS, EXAMPLE, endings=(*ENDINGS, PAGE))
def identify(
    recording: Annotated[
        Path,
        typer.Argument(
            help="Time series, .csv or .parquet, or - for standard input, with the columns "
            "footpoint and moment_z, or footpoint, force_x and force_y, or all four, each with its "
            "unit: 'force_x [N]'."
        ),
    ],
    setup: Setup,
    method: Annotated[
        Method | None,
        option(
            "model: from all channels, by the model of the rod; ratio: from the ratio of the "
            "forces, without a rod. With a rod, both are computed and compared.",
            SIGNALS,
            show_default="model with a rod, else ratio",
        ),
    ] = None,
    slip_time: Annotated[
        str | None, option("Duration of a slip; its samples are left out: '10 ms'.", SIGNALS)
    ] = None,
    delay: Annotated[
        str | None, option("Delay of the readings by a low-pass filter: '4 ms'.", SIGNALS)
    ] = None,
    output: Annotated[
        Path | None,
        option(
            "Table to write: .csv or .parquet; - for standard output. With .html: one sheet with "
            "the loads, mu0 along the surface, residuals and doubts.",
            "Output",
            "--output",
            "-o",
        ),
    ] = None,
    profile: Annotated[
        Path | None,
        option(
            "Also locate the contact point of each sample, and write the profile under the tip: "
            "a table (.csv, .parquet).",
            "Output",
        ),
    ] = None,
    picture: Annotated[
        Path | None,
        option("Picture of the profile: .png, .svg or .pdf.", "Output"),
    ] = None,
    verbose: Annotated[
        bool,
        option("Also print assumed tolerances and all estimates.", "Output", "--verbose", "-v"),
    ] = False,
) -> None:
    """Find the periods of sticking in a measured time series, and the friction of each.

    The table has one row for each period: position of the tip, mu0 with its standard deviation and
    95 % interval, the lines of its samples, and the reason if the period is doubtful. Lines with a
    missing value, a saturated reading or a spike are left out and listed. If a round rod buckles
    laterally, the lines after that are left out, too. The exit code is 2 after an error in the
    input.
    """
    sheet = output if output is not None and output.suffix.lower() == PAGE else None
    if sheet is not None:
        # Fails at once if a library is missing, and takes half a second to load.
        from vibrissa.strip.page import page
    setup = with_modulus(setup)
    material = material_of(setup)
    density = density_of(setup, material)
    if density is not None:
        setup = setup.model_copy(update={"density": Measured(f"{density:.10g} kg/m^3")})
    if profile is not None:
        check_ending(profile)
    if picture is not None:
        check_ending(picture, PICTURES)
        require("plots", "matplotlib")
    found = sensor.identify(
        setup,
        recording,
        method=method,
        slip_time=slip_time,
        delay=delay,
        profile=profile is not None or picture is not None,
    )
    if profile is not None and found.profile is not None:
        write(profile, found.profile)
    if picture is not None and found.profile is not None:
        from vibrissa.figures.profile import save_profile

        save_profile(found.profile.to_pandas(), picture)
    notes = list(_notes(found, verbose))
    lines = [*found.summary().answer(), *found.periods.doubts, *found.summary().details()]
    known = (found.periods.status == PeriodStatus.SLIP).sum()
    place = "" if output is None else f"{output}: "
    written = f"{place}{counted(len(found.periods), 'period')}, friction of {known} of them"
    text = "\n".join((*lines, *found.periods.left_out, *notes, written))
    if sheet is not None:
        with write_atomically(sheet) as temporary:
            temporary.write_text(page(found, str(recording), notes), encoding="utf-8")
    hand_out(found, text, None if sheet is not None else output)
    periods = found.periods
    slips = (periods.status == PeriodStatus.SLIP) & (periods.grade != Grade.WRONG)
    # Without the model, the positions may lead to heights that no rod has.
    if (found.by_model or found.beside is not None) and slips.any():
        # The rod bends most at its least height.
        lowest = setup.whisker.level(float(setup.whisker.distance(periods.footpoint[slips]).min()))
        onset = float(lowest.curve.onset(periods.mu0[slips].max()))
        warn(lowest, onset if np.isfinite(onset) else lowest.curve.x0_lock, material)


def _notes(found: Identification, verbose: bool) -> Iterator[str]:
    """Count assumed tolerances; list estimates far from given values, or all."""
    given = [one.parameter for one in found.estimates]
    assumed = list(dict.fromkeys(one.of for one in given if not one.stated))
    if assumed:
        yield (
            f"{counted(len(assumed), 'tolerance')} assumed (--verbose names them); state yours by "
            f"--tolerance name=size: {see_page('Friction from your recording')}"
        )
    if assumed and verbose:
        yield f"assumed: {', '.join(assumed)}"
    left = found.summary().if_exact
    for parameter, one in zip(given, found.estimates, strict=True):
        if one.far or (verbose and parameter.stated and not parameter.wave):
            exact = left.get(parameter.of)
            more = "" if exact is None else f"; if it were exact, mu0 ± {exact:.2g}"
            yield f"{one.spelled(found.units)}{more}"

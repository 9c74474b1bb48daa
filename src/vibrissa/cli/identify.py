"""``vibrissa identify``: from a measured time series to friction."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

from vibrissa import sensor
from vibrissa.cli import ALONE, HELP
from vibrissa.cli.options import OUTPUT, Json, MaybeOut, Picture, hand_out, option, progress_bars
from vibrissa.cli.setup import ANGLES, MOUNTING, ROD, SIGNALS, SIZES, takes
from vibrissa.cli.yielding import end_of, warn_of_yield
from vibrissa.design.materials import likely_material
from vibrissa.sensor import Grade, Identification, Method, PeriodStatus, Setup, series
from vibrissa.wording import counted, see_page

app = typer.Typer(**ALONE)

PANELS = {ROD: (*SIZES, "material"), MOUNTING: ANGLES, SIGNALS: ("transducer", "noise")}


@app.command(
    context_settings=HELP,
    epilog="Example: `vibrissa identify scan.csv --theta 2 --eta 0.85 --noise '0.003, 0.003, "
    "0.0002' -o friction.csv`",
)
@takes("setup", Setup, PANELS, tolerances=True)
def identify(
    recording: Annotated[
        Path,
        typer.Argument(
            help="Time series, .csv or .parquet, or - for standard input, with the columns "
            "footpoint, force_x, force_y and moment_z, each with its unit: 'force_x [N]'.",
        ),
    ],
    setup: Setup,
    method: Annotated[
        Method | None,
        option(
            "model: all channels, through the model of the rod; ratio: both forces, without a rod. "
            "The other method is computed, too, and compared.",
            *("", SIGNALS),
            show_default="model with a rod, else ratio",
        ),
    ] = None,
    slip_time: Annotated[
        str | None,
        option("Duration of a slip, whose samples are left out: '10 ms'.", "<time>", SIGNALS),
    ] = None,
    delay: Annotated[
        str | None,
        option("Delay of the readings, as by a low-pass filter: '4 ms'.", "<time>", SIGNALS),
    ] = None,
    output: MaybeOut = None,
    picture: Picture = None,
    json: Json = False,
    verbose: Annotated[
        bool,
        option("Print assumed tolerances and all estimates, too.", "", OUTPUT, "--verbose", "-v"),
    ] = False,
) -> None:
    """Find the periods of sticking in a measured time series, and the friction of each.

    The table has one row for each period: position of the tip, mu0 with its standard deviation and
    95 % interval, the lines of its samples, and why it may be in doubt. Lines that miss a value,
    are saturated or are spikes are left out and named, and so is what follows where a round rod
    buckles. The exit code is 2 after an error in the input.
    """
    whisker = None if setup.theta is None and setup.eta is None else setup.whisker
    material = likely_material(setup)
    found = sensor.identify(
        whisker,
        recording,
        method=method,
        transducer=setup.transducer,
        noise=setup.noise,
        # A whisker has its tolerances.
        tolerances=setup.tolerances if whisker is None else None,
        assume=setup.assume,
        slip_time=slip_time,
        delay=delay,
        progress=progress_bars(),
    )
    hand_out(found, output, picture, json)
    _print(found, output, verbose, err=json or output == series.STANDARD)
    if whisker is not None:
        slips = (found.periods.status == PeriodStatus.SLIP) & (found.periods.grade != Grade.WRONG)
        warn_of_yield(whisker, end_of(whisker, found.periods.mu0[slips]), material)


def _print(found: Identification, output: Path | None, verbose: bool, err: bool) -> None:
    known = (found.periods.status == PeriodStatus.SLIP).sum()
    place = "" if output is None else f"{output}: "
    typer.echo(
        f"{place}{counted(len(found.periods), 'period')}, friction of {known} of them", err=err
    )
    typer.echo(found.summary(), err=err)
    for note in found.periods.notes:
        typer.echo(note, err=True)
    for text in _tolerated(found, verbose):
        typer.echo(text, err=err)


def _tolerated(found: Identification, verbose: bool) -> Iterator[str]:
    """Print the assumed tolerances, and the estimate and remaining error of each quantity."""
    unstated = (one for one in found.tolerances if not one.stated)
    assumed = list(dict.fromkeys(one.of for one in unstated))
    if assumed:
        yield (
            f"{counted(len(assumed), 'tolerance')} assumed, named by --verbose; state yours with "
            f"--tolerance name=size: {see_page('Friction from your recording')}"
        )
        if verbose:
            yield f"assumed: {', '.join(assumed)}"
    left = found.summary().if_exact
    for one in found.tolerances:
        moved = one.far
        if (verbose and one.stated and not one.wave) or moved:
            exact = f"; if it were exact, mu0 ± {left[one.of]:.2g}" if one.of in left else ""
            yield f"{one.spelled(found.units)}{exact}"

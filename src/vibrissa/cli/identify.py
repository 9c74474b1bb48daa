"""``vibrissa identify``: from a measured time series to friction."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

from vibrissa import sensor
from vibrissa.cli.options import (
    ALONE,
    Out,
    Picture,
    Transducer,
    check_files,
    check_not_read,
    progress_bars,
    save_picture,
    say,
)
from vibrissa.cli.whisker import Tolerances, read_pairs, takes_whisker
from vibrissa.cli.yielding import Material, YieldStrain, elastic_limit, end_of, warn_of_yield
from vibrissa.sensor import Grade, Identification, Method, PeriodStatus, series
from vibrissa.sensor.given.tolerances import EXACT
from vibrissa.sensor.identification.adjusted import FAR
from vibrissa.wording import counted

app = typer.Typer(**ALONE)


@app.command(
    epilog="Example: `vibrissa identify scan.csv --theta 2 --eta 0.85 --noise '0.003, 0.003, "
    "0.0002' -o friction.csv`"
)
@takes_whisker
def identify(
    recording: Annotated[
        Path,
        typer.Argument(
            help="Time series, .csv or .parquet, or - for standard input: columns footpoint, "
            "force_x, force_y, moment_z as far as the method needs them, each with its unit: "
            "'footpoint [mm],force_x [N]'."
        ),
    ],
    output: Out,
    whisker: sensor.Whisker | None = None,
    method: Annotated[
        Method | None,
        typer.Option(
            help="model: all channels through the model of the rod; ratio: both forces, without a "
            "rod. The other is read beside it, and compared.",
            show_default="model with a rod, ratio without",
        ),
    ] = None,
    transducer: Transducer = None,
    noise: Annotated[
        str | None,
        typer.Option(
            help="Standard deviation of one reading of force_x, force_y and moment_z: "
            "'3 mN, 3 mN, 10 uN*m'. Without it and without a transducer it is estimated from the "
            "recording."
        ),
    ] = None,
    tolerances: Tolerances = None,
    slip_time: Annotated[
        str | None,
        typer.Option(help="How long a slip lasts: '10 ms'. Its samples are left out."),
    ] = None,
    delay: Annotated[
        str | None,
        typer.Option(help="By which the readings lag, as a low-pass filter makes them: '4 ms'."),
    ] = None,
    material: Material = None,
    yield_strain: YieldStrain = None,
    picture: Picture = None,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="Say what was assumed, and what was adjusted.")
    ] = False,
) -> None:
    """Find the periods of sticking in a measured time series, and the friction of each.

    Writes one row for each period: position of the tip, mu0 with its standard deviation and 95 %
    interval, the lines of its samples, and why it may be in doubt. Lines that miss a value, are
    saturated or are spikes are left out and named, and so is what follows where a round rod swings
    aside. The exit code is 2 after a mistake in the input.
    """
    check_files(output, picture)
    check_not_read(output, recording)
    limit = None if whisker is None else elastic_limit(whisker, material, yield_strain)
    stated = [text for text in tolerances or () if text != EXACT]
    found = sensor.identify(
        whisker,
        recording,
        method=method,
        transducer=transducer,
        noise=noise,
        # Those of a rod that is given come with it.
        tolerances=read_pairs(stated) if whisker is None else None,
        assume=EXACT not in (tolerances or ()),
        slip_time=slip_time,
        delay=delay,
        progress=progress_bars(),
    )
    series.write(output, found.columns())
    if picture is not None:
        save_picture(found.plot(), picture)
    known = (found.periods.status == PeriodStatus.SLIP).sum()
    written = f"{output}: {counted(len(found.periods), 'period')}, friction of {known} of them"
    # What was asked for first.
    for text in (written, found.summary()):
        say(text, output)
    for note in found.periods.notes:
        typer.echo(note, err=True)
    for text in _tolerated(found, verbose):
        say(text, output)
    if whisker is not None and limit is not None:
        slips = (found.periods.status == PeriodStatus.SLIP) & (found.periods.grade != Grade.WRONG)
        warn_of_yield(whisker, end_of(whisker, found.periods.mu0[slips]), limit)


def _tolerated(found: Identification, verbose: bool) -> Iterator[str]:
    """Say which tolerances were assumed, and what of them the recording tells or leaves."""
    unstated = (one for one in found.tolerances if not one.stated)
    assumed = list(dict.fromkeys(one.of for one in unstated))
    if assumed:
        yield (
            f"{counted(len(assumed), 'tolerance')} assumed, see --verbose and the page Tolerances; "
            "state yours with --tolerance name=size"
        )
        if verbose:
            yield f"assumed: {', '.join(assumed)}"
    left = found.summary().if_exact
    for one in found.tolerances:
        moved = not one.wave and one.surprise > FAR
        if (verbose and one.stated and not one.wave) or moved:
            exact = f"; if it were exact, mu0 ± {left[one.of]:.2g}" if one.of in left else ""
            yield f"{one.spelled(found.units)}{exact}"

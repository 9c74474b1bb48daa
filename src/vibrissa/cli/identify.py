"""``vibrissa identify``: from a measured time series to friction."""

from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import Annotated

import typer

from vibrissa import sensor
from vibrissa.cli.options import (
    ALONE,
    Out,
    Picture,
    ReadFrom,
    Transducer,
    check_files,
    check_not_read,
    progress_bars,
    save_picture,
    say,
)
from vibrissa.cli.whisker import Tolerances, read_pairs, takes_whisker
from vibrissa.sensor import Identification, Method, PeriodStatus, SlipLaw, Unknown, series
from vibrissa.sensor.given.tolerances import EXACT
from vibrissa.sensor.identification.adjusting.adjustment import FAR
from vibrissa.sensor.identification.calibration import NAMES
from vibrissa.sensor.quantities import CHANNEL_KINDS, Kind
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
    method: ReadFrom = Method.FORCES,
    transducer: Transducer = None,
    noise: Annotated[
        str | None,
        typer.Option(
            help="Standard deviation of one reading of force_x, force_y and moment_z: "
            "'3 mN, 3 mN, 10 uN*m'. Without it and without a transducer it is estimated from the "
            "recording."
        ),
    ] = None,
    step: Annotated[
        str | None, typer.Option(help="Step of the stage, if samples were lost: '20 um'.")
    ] = None,
    law: Annotated[
        SlipLaw | None,
        typer.Option(
            help="Where slips end, for the method spacing. Without it only bounds are found."
        ),
    ] = None,
    kinetic_ratio: Annotated[
        str | None,
        typer.Option(help="Kinetic over static friction, for the method spacing: '0.8 ± 0.03'."),
    ] = None,
    estimate: Annotated[
        list[str] | None,
        typer.Option(
            help="Estimate this, too, as it is not known; repeat it. eta: the height, near the "
            "given one. offset: the reading of each channel without load. Or any name of a "
            "tolerance."
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
    picture: Picture = None,
) -> None:
    """Find the periods of sticking in a measured time series, and the friction of each.

    Writes one row for each period: position of the tip, mu0 with its standard deviation and 95 %
    interval, on which side of the clamp it was, the lines of its samples, and why it may be in
    doubt. Where a round rod swings aside a period has two rows. Lines that miss a value, are
    saturated or are spikes are left out and named. The exit code is 1 if the recording does not
    determine what is to be estimated, 2 after a mistake in the input.
    """
    check_files(output, picture)
    check_not_read(output, recording)
    stated = [text for text in tolerances or () if text != EXACT]
    found = sensor.identify(
        whisker,
        recording,
        method=method,
        transducer=transducer,
        noise=noise,
        step=step,
        law=law,
        kinetic_ratio=kinetic_ratio,
        estimate=estimate or (),
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
    for text in (*_estimated(found), *_tolerated(found)):
        say(text, output)


def _tolerated(found: Identification) -> Iterator[str]:
    """Say which tolerances were assumed, and what of them the recording tells or leaves."""
    unstated = (one for one in found.tolerances if not (one.stated or one.estimated))
    assumed = list(dict.fromkeys(one.of for one in unstated))
    if assumed:
        yield (
            f"Nothing is stated about {', '.join(assumed)}: tolerances are assumed "
            "(docs/tolerances.md); state yours, or --tolerance exact"
        )
    left = found.summary().if_exact
    for one in found.tolerances:
        if one.of == "kinetic_ratio" and found.periods.kinetic is not None:
            # A note has said what the recording tells; nothing was given.
            continue
        moved = not one.wave and one.surprise > FAR
        if (one.stated and not one.wave) or moved or one.estimated:
            exact = f"; if it were exact, mu0 ± {left[one.of]:.2g}" if one.of in left else ""
            yield f"{one.spelled(found.units)}{exact}"


def _estimated(found: Identification) -> Iterator[str]:
    """Say what was estimated, its standard deviations and its correlations."""
    setup, units = found.setup, found.units
    if setup is None:
        return
    values = (setup.eta, *setup.offset)
    kinds = (Kind.LENGTH, *CHANNEL_KINDS)
    free = [i for i, deviation in enumerate(setup.deviation) if deviation > 0.0]
    for i in free:
        what = NAMES[i] if NAMES[i] == Unknown.ETA else f"offset of {NAMES[i]}"
        error = units.spelled(setup.deviation[i], kinds[i], 2)
        yield f"{what} = {units.spelled(values[i], kinds[i])} ± {error} (one deviation)"
    for i, j in combinations(free, 2):
        yield f"correlation of {NAMES[i]} and {NAMES[j]}: {setup.correlation[i, j]:+.2f}"

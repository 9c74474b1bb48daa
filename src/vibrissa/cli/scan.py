"""``vibrissa scan``: from a surface to the signals of the clamp."""

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
from vibrissa.cli.whisker import say_exact, takes_whisker
from vibrissa.cli.yielding import Material, YieldStrain, elastic_limit, warn_of_yield
from vibrissa.sensor import SlipLaw, series, surfaces

app = typer.Typer(**ALONE)

# Of scans for which none is given.
KINETIC_RATIO = 0.8


@app.command(
    epilog="Example: `vibrissa scan --theta 2 --eta 0.85 --mu0 0.4 --step 0.001 --to 1 -o a.csv`"
)
@takes_whisker
def scan(
    whisker: sensor.Whisker,
    step: Annotated[str, typer.Option(help="Step of the stage: '20 um'.")],
    to: Annotated[
        list[str],
        typer.Option(help="Where the stage stops. Repeat it for where it turns: --to 1 --to 0."),
    ],
    output: Out,
    mu0: Annotated[
        str | None, typer.Option(help="Surface with the same friction everywhere.")
    ] = None,
    patches: Annotated[
        str | None, typer.Option(help="Surface of patches: '0 mm: 0.3, 50 mm: 0.4'.")
    ] = None,
    profile: Annotated[
        Path | None, typer.Option(help="Measured surface: a table with columns x and mu0.")
    ] = None,
    texture: Annotated[
        str | None,
        typer.Option(help="Surface of random friction: 'mean, deviation, correlation length'."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the texture and of the noise.")] = 0,
    law: Annotated[SlipLaw, typer.Option(help="Where a slip ends; see docs/simulate.md.")] = (
        SlipLaw.FREE
    ),
    kinetic_ratio: Annotated[
        float | None,
        typer.Option(
            help="Kinetic over static friction, for the laws kinetic and energy.",
            show_default=str(KINETIC_RATIO),
        ),
    ] = None,
    transducer: Transducer = None,
    material: Material = None,
    yield_strain: YieldStrain = None,
    picture: Picture = None,
) -> None:
    """Move the clamp over a surface and write the signals, step by step.

    A sensor records the columns `footpoint`, `force_x`, `force_y` and `moment_z`. The others are
    known only here: position of the tip, x0, friction under the tip, period and phase.
    """
    check_files(output, picture)
    check_not_read(output, profile)
    say_exact(whisker, "scan")
    limit = elastic_limit(whisker, material, yield_strain)
    if law is SlipLaw.FREE and kinetic_ratio is not None:
        typer.echo(
            "the law free uses no kinetic ratio; --law kinetic and --law energy do", err=True
        )
    surface = surfaces.read_surface(
        whisker.units, mu0=mu0, patches=patches, profile=profile, texture=texture, seed=seed
    )
    signals = sensor.scan(
        whisker,
        surface,
        step=step,
        to=to,
        law=law,
        kinetic_ratio=KINETIC_RATIO if kinetic_ratio is None else kinetic_ratio,
        transducer=transducer,
        seed=seed,
        progress=progress_bars(),
    )
    series.write(output, signals.columns())
    if picture is not None:
        save_picture(signals.plot(), picture)
    say(f"{output}: {signals}", output)
    warn_of_yield(whisker, float(signals.truth.x0.max()), limit)

"""``vibrissa scan``: from a surface to the signals of the clamp."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np

from vibrissa import sensor
from vibrissa.cli.options import SETUP, Out, command, hand_out, option
from vibrissa.cli.warnings import material_of, warn, with_modulus
from vibrissa.scanning import SlipLaw
from vibrissa.scanning.scan import TipSide
from vibrissa.sensor import Setup
from vibrissa.sensor.surface_texts import read_heights, read_surface
from vibrissa.sensor.transducer import transducer_of
from vibrissa.wording import see_page

SURFACE, MOTION = "Surface", "Motion"
EXAMPLE = "Example: `vibrissa scan --theta 2 --eta 0.85 --mu0 0.4 --step 0.001 --to 1 -o a.csv`"


@command({**SETUP, "Signals": ("transducer",)}, EXAMPLE)
def scan(
    setup: Setup,
    step: Annotated[str, option("Step of the stage: '20 um'.", MOTION)],
    to: Annotated[
        list[str],
        option("Position at which the stage stops. Repeat to go back: --to 1 --to 0.", MOTION),
    ],
    output: Out,
    mu0: Annotated[str | None, option("Constant friction coefficient.", SURFACE)] = None,
    patches: Annotated[
        str | None, option("Start and mu0 of each patch: '0 mm: 0.3, 50 mm: 0.4'.", SURFACE)
    ] = None,
    profile: Annotated[
        Path | None, option("Measured surface: a table with columns x and mu0.", SURFACE)
    ] = None,
    texture: Annotated[
        str | None, option("Random friction: 'mean, deviation, correlation length'.", SURFACE)
    ] = None,
    heights: Annotated[
        Path | None,
        option(
            "Measured heights: a table with columns x and height, or a profilometer's file (.x3p, "
            ".sdf, .sur, ...), of which one row is levelled.",
            SURFACE,
        ),
    ] = None,
    heights_start: Annotated[
        str, option("Position of the file's x = 0 on the surface: '40 mm'.", SURFACE)
    ] = "0",
    heights_row: Annotated[
        int | None,
        option("Row of a profilometer's file, from 1.", SURFACE, show_default="the middle one"),
    ] = None,
    heights_cutoff: Annotated[
        str | None,
        option("Cutoff of a Gaussian low-pass filter of such a file: '8 um'.", SURFACE),
    ] = None,
    wave: Annotated[str | None, option("Wavy heights: 'amplitude, wavelength'.", SURFACE)] = None,
    grooves: Annotated[
        str | None, option("Grooves: 'width, depth, pitch, angle of the walls'.", SURFACE)
    ] = None,
    rough: Annotated[
        str | None, option("Random heights: 'deviation, correlation length'.", SURFACE)
    ] = None,
    lay: Annotated[
        str | None, option("Angle of the motion to the direction across the grooves.", SURFACE)
    ] = None,
    tip_radius: Annotated[
        str, option("Radius of a ball at the tip, which traces the heights.", SURFACE)
    ] = "0",
    seed: Annotated[int, option("Seed of random surfaces and of the noise.", SURFACE, min=0)] = 0,
    law: Annotated[
        SlipLaw, option(f"Where a slip ends: {see_page('Simulate a sensor')}.", MOTION)
    ] = SlipLaw.FREE,
    kinetic_ratio: Annotated[
        float, option("Kinetic over static friction, for all laws but free.", MOTION)
    ] = 0.8,
    damping: Annotated[
        float | None, option("Damping ratio of the rod, for the law damped.", MOTION)
    ] = None,
) -> None:
    """Move the clamp over a surface and write the signals, step by step.

    A sensor would record the columns `footpoint`, `force_x`, `force_y` and `moment_z`. The other
    columns of the table are known only in a simulation: position of the tip, x0, friction, height
    and inclination under the tip, period and phase.
    """
    setup = with_modulus(setup)
    whisker, material = setup.whisker, material_of(setup)
    surface = read_surface(
        whisker.units, mu0=mu0, patches=patches, profile=profile, texture=texture, seed=seed
    )
    relief = read_heights(
        whisker.units,
        heights=heights,
        wave=wave,
        grooves=grooves,
        rough=rough,
        lay=lay,
        seed=seed,
        start=heights_start,
        row=heights_row,
        cutoff=heights_cutoff,
    )
    if relief is not None:
        surface = surface.with_texture(relief.texture)
    # A wrong name is refused before any work.
    transducer = setup.transducer and transducer_of(setup.transducer, whisker.units)
    signals = sensor.scan(
        whisker,
        surface,
        step=step,
        to=to,
        law=law,
        kinetic_ratio=kinetic_ratio,
        damping=damping,
        tip_radius=tip_radius,
    )
    if relief is not None and relief.about:
        signals = replace(signals, about={"heights": relief.about})
    if transducer:
        signals = signals.measured(transducer, seed)
    hand_out(signals, f"{output}: {signals}", output)
    # The rod bends most at its least height.
    truth = signals.truth
    lowest = whisker.level(float((whisker.distance(truth.clamp) - truth.height).min()))
    # A tip behind the clamp has the mirror image of a state whose x0 has the other sign.
    x0 = np.where(signals.truth.side == TipSide.BEHIND, -1.0, 1.0) * signals.truth.x0
    warn(lowest, float(x0.max()), material, float(x0.min()))

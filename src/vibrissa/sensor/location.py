"""Location of the contact point from the load on the clamp, without a model of the surface.

The load on the clamp determines the shape of the rod: its slope, position and bending moment are
integrated from the clamp on, up to the last place where the bending moment vanishes, the contact
point.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.mechanics.mounting import CLAMP_SLOPE, polynomial
from vibrissa.mechanics.taper import stiffness, stiffness_factor
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import Batch
from vibrissa.quantities import series
from vibrissa.quantities.units import CHANNEL_KINDS, Kind
from vibrissa.scanning.rods import MountedRod
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.sensor.whisker import Whisker

if TYPE_CHECKING:
    from pandas import DataFrame

# Number of steps of the integration along the rod; the error of a position is about 1e-11 L.
STEPS = 800
# Length by which a rod is continued beyond its tip (L).
PAST = 0.02
# Number of secant steps to the place where the moment vanishes.
SECANTS = 6


@dataclass(frozen=True, eq=False, kw_only=True)
class Located(Batch):
    """Contact point and contact force of each sample; lengths in L, forces in E·I0/L².

    Attributes
    ----------
    x, y : ndarray, shape (n,)
        Position of the contact point: x along the stage's surface from the start of the clamp, y
        above the clamp.
    s_c : ndarray, shape (n,)
        Arc length of the contact point: 1 at the tip, less on the flank.
    phi : ndarray, shape (n,)
        Slope of the rod there (rad).
    along, across : ndarray, shape (n,)
        Force of the surface on the rod, along the rod and across it, to the left of its direction.
    moment : ndarray, shape (n,)
        Bending moment left at `s_c` (E·I0/L): 0, unless it vanishes nowhere on the rod. Then the
        load is that of no contact by one force, up to errors of the readings.
    """

    x: FloatArray
    y: FloatArray
    s_c: FloatArray
    phi: FloatArray
    along: FloatArray
    across: FloatArray
    moment: FloatArray


def locate(whisker: Whisker, readings: "Path | DataFrame") -> Located:
    """Locate the contact point of each sample of a recording.

    Neither friction nor the surface matters, and the rod may touch at its tip or on its flank; it
    touches at one place.

    Parameters
    ----------
    whisker : Whisker
        The rod, its mounting and its height.
    readings : Path or DataFrame
        Table with the columns footpoint, force_x, force_y and moment_z.

    Raises
    ------
    RecordingError
        If the table cannot be read.
    ArgumentError
        If a unit is wrong.
    """
    table = series.read(readings, ["footpoint", *CHANNELS])
    kinds = dict(zip(("footpoint", *CHANNELS), (Kind.LENGTH, *CHANNEL_KINDS), strict=True))
    columns = {
        name: table.columns[name]
        * whisker.units.column_factor(
            table.units.get(name, kind.own), kind, f"{table.source}: {name}"
        )
        for name, kind in kinds.items()
    }
    loads = np.stack([columns[name] for name in CHANNELS], axis=1)
    return located(whisker, columns["footpoint"], loads)


def located(rod: MountedRod, clamp: FloatArray, loads: FloatArray) -> Located:
    """Locate the contact points for loads on the clamp.

    Parameters
    ----------
    clamp : ndarray, shape (n,)
        Position of the clamp along its stage (L).
    loads : ndarray, shape (n, 3)
        Clamp reactions fx, fy (E·I0/L²) and m (E·I0/L).
    """
    fx, fy, moment = np.asarray(loads, dtype=float).T
    mounting = rod.mounting
    slope = CLAMP_SLOPE + mounting.clamp_angle + mounting.clamp_compliance * moment
    # Position (L), slope (rad) and bending moment (E·I0/L) at one arc length.
    state = np.array([np.zeros(len(fx)), np.zeros(len(fx)), slope, moment])
    ends = np.ones(len(fx))
    step = 1.0 / STEPS
    # A tip that touches has a moment of 0 at s = 1 up to the errors of the readings: the rod is
    # continued a little. An S-shaped rod has a moment of 0 at its turning point, too.
    past = int(min(PAST, 0.25 / rod.theta) * STEPS)
    contact = state
    tip = state
    vanishes = np.zeros(len(fx), dtype=bool)
    for number in range(STEPS + past):
        if number == STEPS:
            tip = state
        s = np.full(len(fx), number * step)
        after = _stepped(rod, fx, fy, s, state, np.full(len(fx), step))
        crossed = (state[3] * after[3] <= 0.0) & (state[3] != 0.0)
        if crossed.any():
            part, there = _vanishing(
                rod, fx[crossed], fy[crossed], s[crossed], state[:, crossed], step
            )
            contact = contact.copy()
            ends = ends.copy()
            ends[crossed] = s[crossed] + part
            contact[:, crossed] = there
            vanishes = vanishes | crossed
        state = after
    at_tip = ~vanishes | (ends >= 1.0)
    contact = np.where(at_tip, tip, contact)
    ends = np.where(at_tip, 1.0, ends)
    x, y, phi, left = contact
    along_stage = clamp * np.cos(mounting.stage_angle)
    cos, sin = np.cos(phi), np.sin(phi)
    return Located(
        x=along_stage + x,
        y=clamp * np.sin(mounting.stage_angle) + y,
        s_c=ends,
        phi=phi,
        along=fx * cos + fy * sin,
        across=fy * cos - fx * sin,
        moment=left,
    )


def _vanishing(
    rod: MountedRod, fx: FloatArray, fy: FloatArray, s: FloatArray, state: FloatArray, step: float
) -> tuple[FloatArray, FloatArray]:
    """Find the part of a step after which the moment vanishes, and the state there."""
    part = np.zeros(len(s))
    there = state
    for _ in range(SECANTS):
        gradient = fx * np.sin(there[2]) - fy * np.cos(there[2])
        part = np.clip(part - there[3] / gradient, 0.0, step)
        there = _stepped(rod, fx, fy, s, state, part)
    return part, there


def _stepped(
    rod: MountedRod,
    fx: FloatArray,
    fy: FloatArray,
    s: FloatArray,
    state: FloatArray,
    step: FloatArray,
) -> FloatArray:
    """Integrate the equilibrium of rods over one step of the classical Runge–Kutta method."""
    curvature = np.broadcast_to(rod.mounting.coefficients, (len(s), len(rod.mounting.coefficients)))

    def change(s: FloatArray, state: FloatArray) -> FloatArray:
        _, _, phi, m = state
        # A rod that is continued past its tip keeps the factor of the tip.
        factor = stiffness_factor(np.minimum(s, 1.0), rod.theta, rod.mounting.making)
        bent = m / (stiffness(s, rod.theta) * factor)
        natural = polynomial(curvature, s[:, None])[:, 0]
        sin, cos = np.sin(phi), np.cos(phi)
        return np.array([cos, sin, bent + natural, fx * sin - fy * cos])

    first = change(s, state)
    second = change(s + 0.5 * step, state + 0.5 * step * first)
    third = change(s + 0.5 * step, state + 0.5 * step * second)
    fourth = change(s + step, state + step * third)
    return state + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)

"""Which tolerance limits the friction that a rod reads, and what halving it brings.

The rod is moved over a surface of one friction, without noise, and the recording is read as if one
thing were a little larger than it was given, one after the other. The change of μ0 per change of
that thing, times its tolerance, is the part of that tolerance.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from vibrissa.design.requirements import Requirements
from vibrissa.sensor import surfaces
from vibrissa.sensor.given.tolerances import assumed_tolerances, told
from vibrissa.sensor.identification.adjusting.properties import PROPERTIES
from vibrissa.sensor.identification.calibration import known_setup
from vibrissa.sensor.identification.friction import PeriodStatus, find_periods
from vibrissa.sensor.identification.recording import Recording
from vibrissa.sensor.quantities import Kind, Units
from vibrissa.sensor.simulation.scanning import simulate
from vibrissa.sensor.simulation.slips import SlipLaw
from vibrissa.sensor.whisker import Whisker

# Of an oblique stage the rod would be solved at many heights; slips end at α = 0 here.
LEFT_OUT = ("stage_angle", "kinetic_ratio")
# So many periods of sticking are read.
PERIODS = 4
# Sensitivities are differences over this part of a tolerance.
PART = 0.1
# Less noise than this part of the largest reading would tell the changed rod from the given one.
LEAST_NOISE = 2e-3
# A smaller part of all tolerances together is not told.
SHOWN = 0.02


@dataclass(frozen=True, kw_only=True)
class TolerancePart:
    """What one tolerance adds to the uncertainty of μ0, which all periods share.

    Attributes
    ----------
    name : str
    tolerance : float
        Standard deviation, in units of the rod, rad, or relative.
    part : float
        Standard deviation of μ0 by it.
    halved : float
        By which part the standard deviation of μ0, with all tolerances, falls if it is halved.
    """

    name: str
    tolerance: float
    part: float
    halved: float


def tolerance_parts(
    requirements: Requirements, whisker: Whisker, mu0: float, deviation: float
) -> tuple[TolerancePart, ...]:
    """Tell what each tolerance adds to the uncertainty of μ0, the most first.

    Parameters
    ----------
    requirements : Requirements
    whisker : Whisker
        The rod that was found.
    mu0 : float
        Friction of the surface.
    deviation : float
        Standard deviation of μ0 from one period, without tolerances.

    Returns
    -------
    tuple of TolerancePart
        Of the tolerances that `identify` assumes where none is stated.

    Raises
    ------
    NoResponseError
        If the response of the rod is not found, or that of one that is a little other.
    RecordingError
        If its periods cannot be told apart.
    """
    noise = np.array(requirements.noise) / whisker.units.channels
    step = requirements.step / whisker.units.unit(Kind.LENGTH)
    recording = _recorded(whisker, mu0, step)

    # Sensitivities do not depend on it, but what is taken for a state of the rod does.
    enough = np.maximum(noise, LEAST_NOISE * np.abs(recording.readings).max(axis=0))

    def read(other: Whisker, seen: Recording) -> float:
        periods = find_periods(
            known_setup(other.response(False), other.eta),
            seen,
            enough,
            method=requirements.method,
            step=step,
            law=SlipLaw.FREE,
        )
        return float(periods.mu0[periods.status == PeriodStatus.SLIP].mean())

    tolerances = {
        name: size
        for name, size in assumed_tolerances(whisker.units, noise).items()
        if name in PROPERTIES and name not in LEFT_OUT
    }

    def change(name: str, tolerance: float) -> float:
        one, size = PROPERTIES[name], PART * tolerance
        moved = read(one.whisker(whisker, size), one.recording(recording, size))
        return abs(moved - given) / PART

    given, parts = read(whisker, recording), {}
    for name, tolerance in tolerances.items():
        parts[name] = change(name, tolerance)
    total = deviation**2 + sum(part**2 for part in parts.values())
    found = [
        TolerancePart(
            name=name,
            tolerance=tolerances[name],
            part=part,
            halved=1.0 - float(np.sqrt(1.0 - 0.75 * part**2 / total)),
        )
        for name, part in parts.items()
    ]
    return tuple(sorted(found, key=lambda one: -one.part))


def _recorded(whisker: Whisker, mu0: float, step: float) -> Recording:
    """Record some periods of sticking on a surface of one friction, without noise."""
    travel = float(whisker.curve.onset(np.array([mu0]))[0])
    steps = int(np.ceil((PERIODS + 0.5) * travel / step))
    scan = simulate(
        whisker.response(False), surfaces.constant(mu0), step * np.arange(steps + 1.0), SlipLaw.FREE
    )
    return Recording(
        clamp=scan.clamp, readings=scan.reactions, line=np.arange(1, len(scan.clamp) + 1)
    )


def lines(parts: Sequence[TolerancePart], units: Units) -> Iterator[str]:
    """Say which tolerances count, the most first."""
    total = np.sqrt(sum(one.part**2 for one in parts))
    yield "\ntolerance of what is given, and its part in the standard deviation of mu0"
    for one in parts:
        if one.part >= SHOWN * total:
            size, unit = told(one.name, one.tolerance, units)
            yield (
                f"{one.name:<17} {f'{size:.2g} {unit}'.strip():<12} {one.part:<8.2g} "
                f"halving it brings {one.halved:.1%}"
            )

"""What is adjusted to a recording, by how much, and from where: tolerances stated and assumed."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.given.tolerances import TOLERABLE, assumed_tolerances, check_name
from vibrissa.sensor.identification.adjusting.adjustment import Prior
from vibrissa.sensor.identification.adjusting.properties import OF_MOUNTING
from vibrissa.sensor.identification.calibration import Setup, Unknown
from vibrissa.sensor.identification.recording import Method, Recording
from vibrissa.sensor.response.heights import reach_of
from vibrissa.sensor.simulation.slips import SlipLaw
from vibrissa.sensor.whisker import Whisker

ZEROS = ("zero_force_x", "zero_force_y", "zero_moment_z")
# What is asked for as an unknown, and has no tolerance, has so many of those that are assumed.
WIDE = 10.0
# Channels without which a tolerance changes nothing that was recorded.
NEEDS = {"moment_origin_x": 2, "moment_origin_y": 2}


@dataclass(frozen=True, eq=False, kw_only=True)
class Asked:
    """What a person asks for, besides the rod.

    Attributes
    ----------
    method : Method
    law : SlipLaw or None
    estimate : tuple of str
        Names of tolerances, and of `Unknown`.
    assume : bool
        Whether what nothing is stated about has the tolerance that is assumed for it.
    ratio_given : bool
        Whether the ratio of the frictions is; otherwise the readings after slips tell it.
    """

    method: Method
    law: SlipLaw | None
    estimate: tuple[str, ...]
    assume: bool
    ratio_given: bool = True

    @property
    def estimated(self) -> frozenset[str]:
        """Names of the tolerances that are unknown.

        Raises
        ------
        ArgumentError
            If one of them cannot be estimated.
        """
        found = set(self.estimate)
        if Unknown.OFFSET in found:
            found = (found - {Unknown.OFFSET}) | set(ZEROS)
        for name in found:
            check_name(name, "what is estimated is offset or")
            if name == "kinetic_ratio":
                raise ArgumentError("kinetic_ratio cannot be estimated: no reading tells it")
        return frozenset(found)


def prior_of(
    whisker: Whisker,
    recording: Recording,
    noise: FloatArray,
    asked: Asked,
    calibrated: Setup | None,
    swings: bool,
) -> Prior:
    """Put together what is adjusted.

    Parameters
    ----------
    whisker : Whisker
        With the tolerances that were stated.
    recording : Recording
    noise : ndarray, shape (3,)
        Standard deviation of one reading.
    asked : Asked
    calibrated : Setup or None
        Height and zeros, as far as they were estimated before.
    swings : bool
        Whether the rod swings aside: then clamp and rod are taken as symmetric.
    """
    stated, estimated = whisker.tolerances, asked.estimated
    assumed = assumed_tolerances(whisker.units, noise)
    sizes = {**(assumed if asked.assume else {}), **stated}
    # In the order of what is assumed, not of a set: what is told comes in it.
    sizes |= {name: WIDE * assumed[name] for name in assumed if name in estimated - stated.keys()}
    begin: dict[str, float] = {}
    if calibrated is not None:
        largest = np.abs(np.nan_to_num(recording.readings)).max(axis=0)
        known = calibrated.deviation > 0.0
        places = {"eta": (calibrated.eta - whisker.eta, reach_of(whisker.eta))}
        places |= {
            name: (float(calibrated.offset[i]), float(largest[i])) for i, name in enumerate(ZEROS)
        }
        for (name, (begun, wide)), there in zip(places.items(), known, strict=True):
            if there:
                begin[name] = begun
                if name not in stated:
                    sizes[name] = wide
    # What comes before the swing would be adjusted alone, and friction after it is read with it: a
    # dragged tip is so much stiffer that what remains of the errors would not fit there.
    carried = {*OF_MOUNTING, *(set(sizes) - estimated)} if swings else set()
    there = [bool(np.isfinite(column).all()) for column in recording.readings.T]
    return Prior(
        tolerances={
            name: size
            for name, size in sizes.items()
            if size > 0.0 and _matters(name, asked, there)
        },
        stated=frozenset(stated),
        estimated=estimated,
        carried=frozenset(carried),
        level=asked.method is Method.SPACING,
        begin=begin,
    )


def _matters(name: str, asked: Asked, there: Sequence[bool]) -> bool:
    """Tell whether something has a part in what was recorded, or in how it is read."""
    if name == "kinetic_ratio":
        of_law = asked.law in (SlipLaw.KINETIC, SlipLaw.ENERGY)
        return asked.method is Method.SPACING and of_law and asked.ratio_given
    channel = NEEDS.get(name, TOLERABLE[name].channel)
    return channel < 0 or there[channel]


def needs_calibration(estimate: Sequence[str]) -> list[Unknown]:
    """Tell which unknowns may be far from what was given."""
    return [one for one in Unknown if one in estimate]

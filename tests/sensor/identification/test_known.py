"""Everything that is told of small recordings, number by number, under each option.

What the numbers should be is tested elsewhere, by closed forms and other methods. Here they stand
as a whole: every column of the table, every sentence, every tolerance with its covariance.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
import pytest

from known import WITHIN, Known, result_of
from steel import NOISE, ROD, SCALE, SENSOR, measured, recording_of
from vibrissa.mechanics.mounting import Mounting
from vibrissa.sensor import Identification, Whisker, identify, scan, surfaces

KNOWN = Known(__file__)
# An optimiser ends where its steps are small, and not at the optimum to all digits.
OPTIMISED = 1e-4
# Covariances of what is small are smaller still.
FLOOR = 1e-13

GIVEN = Whisker(theta=2.0, eta=0.85)
STEEL = Whisker(theta=2.0, eta=0.85, rod=ROD)
PLANAR = Whisker(theta=2.0, eta=0.85, section="planar")
SKEWED = Whisker(theta=2.0, eta=0.85, mounting=Mounting(clamp_angle=0.02, curvature=-0.05))
LYING = Whisker(theta=3.0, eta=0.7, contact="line")
OBLIQUE = Whisker(theta=2.0, eta=0.85, mounting=Mounting(stage_angle=0.02))
KINETIC = {"law": "kinetic", "kinetic_ratio": 0.8}
TEXTURE = surfaces.random(1, 0.3, 0.02, 0.05)
ROUGH = surfaces.constant(0.9)
WIDE = np.array([0.02, 0.02, 0.005])
ANGLE = np.deg2rad(1.0)
TURNED = np.array(
    [[np.cos(ANGLE), np.sin(ANGLE), 0], [-np.sin(ANGLE), np.cos(ANGLE), 0], [0, 0, 1]]
)


# --- Recordings ---


@cache
def scanned(
    whisker=GIVEN, turns=("0.05",), step="0.0005", law="kinetic", surface=TEXTURE, ratio=0.8
):
    return scan(whisker, surface, step=step, to=turns, law=law, kinetic_ratio=ratio).truth


def recorded(whisker=GIVEN, seed=1, **how):
    truth = scanned(whisker, **how)
    return recording_of(truth.clamp, measured(truth.reactions, seed))


def back(**how):
    """Forward, back, and forward again."""
    return recorded(turns=("0.04", "0.01", "0.025"), **how)


def turned():
    """As a transducer reads that is turned by a degree."""
    return recorded().mixed(TURNED)


def lossy(**how):
    """Three samples in ten are missing."""
    recording = recorded(**how)
    keep = np.random.default_rng(5).random(len(recording)) > 0.3
    keep[:2] = True
    return recording.take(keep)


def gap():
    """Some samples in a row are missing, within a period and over a slip."""
    rows = np.arange(len(recorded()))
    return recorded().take((rows < 12) | ((rows > 27) & (rows < 45)) | (rows > 53))


def dwelling():
    """Three samples at each step."""
    truth = scanned()
    rows = np.repeat(np.arange(len(truth)), 3)
    return recording_of(truth.clamp[rows], measured(truth.reactions[rows], 8))


def spiked():
    readings = recorded().readings.copy()
    readings[[20, 47], 0] += 0.3
    readings[[20, 47], 2] -= 0.1
    return replace(recorded(), readings=readings)


def shifted(channel=2, size=0.005):
    """With a wrong zero."""
    readings = recorded().readings.copy()
    readings[:, channel] += size
    return replace(recorded(), readings=readings)


def without(channel):
    readings = recorded().readings.copy()
    readings[:, channel] = np.nan
    return replace(recorded(), readings=readings)


def drifting():
    """With a zero of the moment that moves in the course of the recording."""
    readings = recorded().readings.copy()
    readings[:, 2] += np.linspace(0.0, 0.004, len(readings))
    return replace(recorded(), readings=readings)


def exact():
    truth = scanned()
    return recording_of(truth.clamp, truth.reactions)


def wide(truth):
    """As a transducer of a wider range reads it, whose noise is part of what it reads at most."""
    rng = np.random.default_rng(1)
    return recording_of(truth.clamp, truth.reactions + WIDE * rng.standard_normal((len(truth), 3)))


def locked():
    """A strip sticks past its lock, and is pulled back before it snaps."""
    how = {"turns": ("0.5", "0.3"), "step": "0.005", "surface": ROUGH}
    return wide(scanned(PLANAR, **how))


def swung():
    """A round rod swings aside, and is dragged."""
    return wide(scanned(turns=("0.95",), step="0.004", law="free", surface=ROUGH))


def frame(seed=1, hum=0.0, lag=0.0, ends=False, step=10.0, turns=("6 mm",)):
    """As a laboratory's file has it: with time and units, 1 mm in a second."""
    way = {"turns": turns, "step": f"{step} um"}
    truth = scanned(STEEL, surface=surfaces.constant(0.3), **way)
    clamp, loads = truth.clamp * ROD.length, truth.reactions * SCALE
    for row in range(1, len(loads)):
        if lag:
            loads[row] += np.exp(-1e-3 * step / lag) * (loads[row - 1] - loads[row])
    if ends:
        part = np.concatenate([np.zeros(40), np.linspace(0, 1, 30), np.ones(50)])[:, None]
        loads = np.concatenate([part * loads[0], loads, part[::-1] * loads[-1]])
        clamp = np.pad(clamp, len(part), mode="edge")
    time = np.arange(len(loads)) * 1e-3 * step
    wave = np.cos(2.0 * np.pi * 50.03 * time[:, None] + np.array([0.3, 1.1, 2.0]))
    rng = np.random.default_rng(seed)
    loads = loads + (hum * wave + rng.standard_normal(loads.shape)) * SENSOR.deviation
    names = ("force_x [N]", "force_y [N]", "moment_z [N*m]")
    columns = {"time [s]": time, "footpoint [m]": clamp}
    return pd.DataFrame(columns | dict(zip(names, loads.T, strict=True)))


# --- What is read of them ---


@dataclass(frozen=True)
class Case:
    """A recording, the rod with which it is read, and the options."""

    recording: Callable[[], Any]
    whisker: Whisker | None = GIVEN
    options: dict[str, Any] = field(default_factory=dict)
    slow: bool = False

    @property
    def close(self) -> float:
        """By which part of the largest beside them its numbers may be other ones."""
        return OPTIMISED if self.options.get("law") == "energy" else WITHIN

    def read(self) -> Identification:
        recording = self.recording()
        own = {} if isinstance(recording, pd.DataFrame) else {"noise": NOISE}
        return identify(self.whisker, recording, **own | {"assume": False} | self.options)


def case(recording, whisker=GIVEN, **options):
    return Case(recording, whisker, options)


def slow(recording, whisker=GIVEN, **options):
    return Case(recording, whisker, options, slow=True)


CASES = {
    "forces": case(recorded),
    "moment": case(recorded, method="moment"),
    "spacing": case(recorded, method="spacing", **KINETIC),
    "ratio": case(recorded, method="ratio"),
    "ratio alone": case(recorded, None, method="ratio"),
    "own noise": case(recorded, noise=None, method="moment"),
    "assumed": slow(recorded, method="moment", assume=True),
    "assumed, forces": slow(recorded, assume=True),
    "assumed, ratio": slow(recorded, method="ratio", assume=True),
    "assumed, ratio alone": case(recorded, None, method="ratio", assume=True),
    "assumed, spacing": slow(recorded, method="spacing", assume=True, **KINETIC),
    "spacing without a law": case(recorded, method="spacing"),
    "spacing, free": case(lambda: recorded(law="free"), method="spacing", law="free"),
    "spacing, ratio by slips": case(recorded, method="spacing", law="kinetic"),
    "spacing, ratio to a tolerance": case(
        recorded, method="spacing", law="kinetic", kinetic_ratio="0.8 ± 0.03"
    ),
    "spacing, wrong ratio": case(recorded, method="spacing", law="kinetic", kinetic_ratio=0.6),
    "spacing of lost samples": case(lossy, method="spacing", step=0.0005, **KINETIC),
    "spacing of lost samples, backward": case(
        lambda: lossy(turns=("-0.04",)), method="spacing", step=0.0005, **KINETIC
    ),
    "spacing, back": case(back, method="spacing", **KINETIC),
    "spacing, energy": slow(
        lambda: recorded(law="energy", turns=("0.35",), step="0.001"),
        method="spacing",
        law="energy",
        kinetic_ratio=0.8,
    ),
    "back": case(back),
    "back, moment": case(back, method="moment"),
    "back, ratio": case(back, method="ratio"),
    "lossy": case(lossy, method="moment"),
    "gap": case(gap),
    "gap, ratio": case(gap, None, method="ratio"),
    "dwelling": case(dwelling, method="moment"),
    "dwelling, ratio": case(dwelling, None, method="ratio"),
    "spiked": case(spiked),
    "spiked, ratio": case(spiked, None, method="ratio"),
    "wrong zero": slow(shifted, method="moment"),
    "wrong zero of a force": slow(lambda: shifted(0, 0.02)),
    "wrong zero, estimated": slow(shifted, method="moment", estimate=["offset"]),
    "wrong zero, tolerated": case(
        shifted, method="moment", tolerances={"zero_moment_z": 0.004, "drift_moment_z": 0.002}
    ),
    "turned": slow(turned, method="moment"),
    "turned, ratio": case(turned, method="ratio", tolerances={"transducer_angle": 0.002}),
    "turned, estimated": case(turned, method="moment", estimate=["transducer_angle"]),
    "turned, crosstalk": case(turned, None, method="ratio", tolerances={"crosstalk": "1 %"}),
    "height estimated": slow(
        recorded, replace(GIVEN, eta=0.855), method="moment", estimate=["eta"]
    ),
    "another taper": slow(recorded, replace(GIVEN, theta=2.05), method="moment"),
    "another taper, tolerated": slow(
        recorded, replace(GIVEN, theta=2.05), method="moment", tolerances={"theta": "1 %"}
    ),
    "another rod": slow(recorded, replace(GIVEN, theta=1.0, eta=0.5)),
    "no forces": slow(lambda: without(0), method="moment", assume=True),
    "no moment": case(lambda: without(2)),
    "skewed": slow(lambda: recorded(SKEWED), SKEWED, method="moment", assume=True),
    "oblique": slow(lambda: recorded(OBLIQUE, turns=("0.03",)), OBLIQUE, method="moment"),
    "locked": case(locked, PLANAR, noise=WIDE),
    "locked, moment": case(locked, PLANAR, method="moment", noise=WIDE),
    "locked, ratio": case(locked, None, method="ratio", noise=WIDE),
    "swung": case(swung, noise=WIDE),
    "swung, with tolerances": case(
        swung, method="moment", noise=WIDE, tolerances={"modulus": "1 %", "zero_force_x": 0.02}
    ),
    "swung, with tolerances of the mounting": slow(
        swung,
        noise=WIDE,
        tolerances={
            "clamp_angle": "0.2 deg",
            "curvature": 0.01,
            "theta": 0.01,
            "transducer_angle": "0.2 deg",
            "stage_scale": 0.001,
            "crosstalk": "0.1 %",
            "drift_force_x": 0.01,
        },
    ),
    "swung, spacing": case(swung, method="spacing", law="free", noise=WIDE),
    "swung, ratio": case(swung, None, method="ratio", noise=WIDE),
    "steel": slow(frame, STEEL, transducer="nano17-si-12-0.12", assume=True),
    "steel, own noise": case(frame, STEEL, method="moment"),
    "steel, told noise": slow(frame, STEEL, method="moment", noise="2 mN, 2 mN, 9 uN*m"),
    "steel, slips told": case(frame, STEEL, method="moment", slip_time="30 ms"),
    "hum": case(lambda: frame(hum=8.0, step=2.0), STEEL, method="moment"),
    "lag": case(lambda: frame(lag=0.04), STEEL, method="moment"),
    "lag, told": case(lambda: frame(lag=0.04), STEEL, method="moment", delay="40 ms"),
    "lag, back": case(lambda: frame(lag=0.04, turns=("6 mm", "-1 mm")), STEEL, method="moment"),
    "lag, forces": case(lambda: frame(lag=0.04), STEEL),
    "rest and lift-off": case(lambda: frame(ends=True), STEEL, method="moment"),
    "in SI alone": case(frame, None, method="ratio", assume=True),
    "spacing, energy with kinetic friction of a half": slow(
        lambda: recorded(
            law="energy", turns=("1.1",), step="0.002", surface=surfaces.constant(0.4), ratio=0.5
        ),
        method="spacing",
        law="energy",
        kinetic_ratio=0.5,
    ),
    "spacing, energy with another ratio": slow(
        lambda: recorded(law="energy", turns=("0.35",), step="0.001"),
        method="spacing",
        law="energy",
        kinetic_ratio=0.3,
    ),
    "spacing, backward": case(lambda: recorded(turns=("-0.04",)), method="spacing", **KINETIC),
    "backward": case(lambda: recorded(turns=("-0.04",)), method="moment"),
    "line contact": case(lambda: recorded(LYING, turns=("0.08",)), LYING),
    "drifting": case(drifting, method="moment", tolerances={"drift_moment_z": 0.003}),
    "drifting, exactly": case(drifting, method="moment"),
    "angle of the stage tolerated": slow(
        recorded, method="spacing", tolerances={"stage_angle": "0.2 deg"}, **KINETIC
    ),
    "modulus far": case(recorded, tolerances={"modulus": "0.01 %", "zero_force_y": 1e-6}),
    "turned, far": case(turned, tolerances={"transducer_angle": "0.1 deg", "modulus": "1 %"}),
    "turned, stated and assumed": slow(
        turned, method="moment", assume=True, tolerances={"transducer_angle": "0.1 deg"}
    ),
    "noise told too small": case(recorded, noise=0.7 * NOISE, method="moment"),
    "noise told too small, height estimated": slow(
        recorded, noise=0.8 * NOISE, method="moment", estimate=["eta"]
    ),
    "noise told much too small, height estimated": slow(
        recorded, noise=0.5 * NOISE, method="moment", estimate=["eta"]
    ),
    "height estimated from afar": slow(recorded, replace(GIVEN, eta=0.9), estimate=["eta"]),
    "height estimated of few": slow(
        lambda: recorded().take(slice(0, 4)), method="moment", estimate=["eta"]
    ),
    "zeros estimated of few": slow(
        lambda: recorded().take(slice(0, 30)), method="moment", estimate=["offset"]
    ),
    "height estimated by the moment alone": slow(
        lambda: without(0).mixed(np.diag([1.0, np.nan, 1.0])),
        method="moment",
        estimate=["eta", "offset"],
    ),
    "crosstalk and all zeros estimated of few": slow(
        lambda: recorded().take(slice(0, 30)),
        method="moment",
        estimate=["transducer_angle", "modulus", "moment_origin_x"],
    ),
    "exact": case(exact, noise=None),
    "exact, ratio": case(exact, None, method="ratio", noise=None),
    "pulls": case(lambda: recorded().mixed(np.diag([1.0, -1.0, 1.0])), None, method="ratio"),
    "two periods": case(lambda: recorded().take(slice(0, 60)), method="spacing", law="kinetic"),
    "rests": case(
        lambda: recording_of(np.zeros(30), recorded().readings[:30]), method="spacing", law="free"
    ),
    "few": case(lambda: recorded().take(slice(0, 5)), method="moment"),
    "swapped": case(lambda: recorded().mixed(np.eye(3)[[1, 0, 2]])),
    "other sign": case(lambda: recorded().mixed(np.diag([-1.0, 1.0, 1.0]))),
    "other sign, ratio": case(
        lambda: recorded().mixed(np.diag([-1.0, 1.0, 1.0])), None, method="ratio"
    ),
    "other unit": case(lambda: recorded().mixed(np.diag([1.0, 1.0, 1000.0])), method="moment"),
}


def summed(matrix):
    """Sums of a matrix along both axes, each row or column with a weight of its own."""
    matrix = np.atleast_2d(np.asarray(matrix, dtype=float))
    rows, columns = (np.sqrt(np.arange(1, size + 1)) for size in matrix.shape)
    if matrix.shape[0] == matrix.shape[1]:
        return matrix @ columns
    return [matrix @ columns, rows @ matrix]


def sizes(one):
    return one.tolerance, one.adjusted, one.deviation, one.surprise


def told(found: Identification) -> dict[str, Any]:
    periods, fit = found.periods, found.periods.goodness
    setup, beside = found.setup, found.beside
    return {
        "table": {name: one.values for name, one in found.columns().items()},
        "units": [one.unit or "-" for one in found.columns().values()],
        "rows": [periods.first, periods.last],
        "effects": summed(periods.effects),
        "shifts": summed(periods.shifts),
        "covariance of periods": summed(found.of_periods),
        "notes": periods.notes,
        "summary": str(found).splitlines(),
        "fit": fit and [fit.chi2, fit.degrees, fit.noise_degrees],
        "chance": fit and fit.chance,
        "noisier": fit and fit.noisier,
        "causes": {one.name: [one.size, one.deviation, one.explained] for one in periods.causes},
        "kinetic": periods.kinetic and [periods.kinetic.value, periods.kinetic.deviation],
        "setup": setup and [setup.eta, *setup.offset],
        "covariance of the setup": setup and summed(setup.covariance),
        "beside": beside and [beside.difference, beside.spread],
        "periods beside": beside and beside.number,
        "tolerances": {
            f"{one.name} of {one.of} {one.stated} {one.estimated}": sizes(one)
            for one in found.tolerances
            if not one.wave
        },
        "waves": summed([[one.wave, *sizes(one)] for one in found.tolerances if one.wave]),
        "covariance": summed(found.covariance),
        "correlation": summed(found.correlation),
        "far": [one.spelled(found.units) for one in found.far],
    }


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow if one.slow else ()) for name, one in CASES.items()],
)
def test_all_that_is_told_of_a_recording_is_as_it_was(name):
    one = CASES[name]
    found = result_of(lambda: told(one.read()))
    KNOWN.check(name, found, one.close, floor=FLOOR, told=True)

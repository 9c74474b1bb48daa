"""Recordings of a rod that is not quite what it was given as, and what is found in them."""

import numpy as np

from steel import NOISE, identified, measured, recording_of
from vibrissa.scanning import surfaces
from vibrissa.scanning.simulation import simulate
from vibrissa.scanning.stage import path
from vibrissa.sensor import Whisker

GIVEN = Whisker(theta=2.0, eta=0.85)


def identify(*given, **asked):
    """Identify with what is stated alone."""
    return identified(*given, assume=False, **asked)


def recorded(whisker, seed=1, scale=1.0, alone=False):
    surface = surfaces.random(seed, 0.3, 0.04, 0.02)
    truth = simulate(whisker.response, surface, path("0.0005", ["0.6"]))
    readings = measured(scale * truth.reactions, [seed, 2])
    if alone:
        readings[:, :2] = np.nan
    return truth, recording_of(truth.clamp, readings)


def bias(found, truth):
    """Mean error of the friction, and its standard deviation."""
    known = found.periods.status == "slip"
    error = (found.periods.mu0 - truth.mu0[found.periods.last])[known]
    own = found.periods.deviation[known] ** 2 - found.periods.common[known] ** 2
    return error.mean(), np.sqrt(own.mean() / len(error) + found.periods.common[known].mean() ** 2)


def carried(seeds):
    """Errors of the mean friction over their deviations, if a modulus is known to 2 % alone.

    Only the moment was recorded, which does not tell the modulus. With each comes the part of the
    deviation of a period that all periods share.
    """
    for seed in seeds:
        error = 0.02 * np.random.default_rng(seed).normal()
        truth, recording = recorded(GIVEN, seed, 1.0 + error, alone=True)
        given = {"modulus": "2 %"}
        found = identify(GIVEN, recording, method="model", noise=NOISE, tolerances=given)
        mean, deviation = bias(found, truth)
        yield mean / deviation, found.periods.common[0] / found.periods.deviation[0]

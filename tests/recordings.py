"""Simulated recordings of a random surface, and what is found in them."""

from functools import lru_cache

from responses import by_law
from steel import NOISE, identified, measured, recording_of
from vibrissa.scanning import surfaces
from vibrissa.scanning.simulation import simulate
from vibrissa.scanning.stage import path
from vibrissa.sensor import Whisker


def found_in(recording, noise=NOISE, **rod):
    """Periods by the model of a rod, of which everything is known exactly."""
    return read(recording, noise, **rod).periods


def read(recording, noise=NOISE, **rod):
    """All that is found by the model of a rod, of which everything is known exactly."""
    whisker = Whisker(**{"theta": 2.0, "eta": 0.85} | rod)
    return identified(whisker, recording, noise=noise, assume=False)


@lru_cache(32)
def recorded(response, seed=1, turns=("1.2",), law="free", step="0.0005"):
    """A scan, and its recording, which is kept for other tests and cannot be changed."""
    surface = surfaces.random(seed, 0.3, 0.04, 0.02)
    truth = simulate(response, surface, path(step, turns), by_law(law))
    recording = recording_of(truth.clamp, measured(truth.reactions, [seed, 1]))
    for values in (recording.clamp, recording.readings, recording.line):
        values.flags.writeable = False
    return truth, recording


def goodness_of(response, seeds, noise):
    """How well recordings that differ by surface and noise fit the rod that they are of."""
    return [read(recorded(response, seed, ("0.6",))[1], noise).goodness for seed in seeds]


def known(periods):
    return periods.status == "slip"


def covered(response, law, seeds):
    """For each period of some recordings, whether the interval of the friction holds it."""
    within = []
    for seed in seeds:
        truth, recording = recorded(response, seed, law=law)
        periods = found_in(recording)
        friction0, ok = truth.mu0[periods.last], known(periods)
        within += list(((periods.low <= friction0) & (friction0 <= periods.high))[ok])
    return within

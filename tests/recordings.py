"""Simulated recordings of a random surface, and what is found in them."""

from responses import by_law
from steel import NOISE, identified, measured, recording_of
from vibrissa.scanning import surfaces
from vibrissa.scanning.simulation import simulate
from vibrissa.scanning.stage import path
from vibrissa.sensor import Whisker


def found_in(recording, noise=NOISE, **rod):
    """Periods by the model of a rod, of which everything is known exactly."""
    whisker = Whisker(**{"theta": 2.0, "eta": 0.85} | rod)
    return identified(whisker, recording, noise=noise, assume=False).periods


def recorded(response, seed=1, turns=("1.2",), law="free", step="0.0005"):
    surface = surfaces.random(seed, 0.3, 0.04, 0.02)
    truth = simulate(response, surface, path(step, turns), by_law(law))
    return truth, recording_of(truth.clamp, measured(truth.reactions, [seed, 1]))


def known(periods):
    return periods.status == "slip"


def covered(response, law):
    """For each period of ten recordings, whether the interval of the friction holds it."""
    within = []
    for seed in range(100, 110):
        truth, recording = recorded(response, seed, law=law)
        periods = found_in(recording)
        friction0, ok = truth.mu0[periods.last], known(periods)
        within += list(((periods.low <= friction0) & (friction0 <= periods.high))[ok])
    return within

"""A rod that swings aside, and the friction of its trailing and dragged tip: bias and coverage.

The whisker and the transducer of `roundtrip` over a random texture on which the tip locks (μ0
0.80 ± 0.06, correlated over 2 mm). Near the swing the moment is beyond the transducer's range.
"""

import argparse
from collections import defaultdict

import numpy as np
from roundtrip import DEVIATION, SCALE, SENSOR, rod

from vibrissa.sensor import PeriodStatus, Recording, path, simulate, surfaces
from vibrissa.sensor.identification.calibration import known_setup
from vibrissa.sensor.identification.friction import find_periods
from vibrissa.sensor.identification.recording import USED, WITH_ROD

POSITIONS = path("0.0005", ["0.95"])


def one(seed, method):
    """Error, whether the interval covers, and deviation, of the trailing tip and of later ones."""
    truth = simulate(rod(), surfaces.random(seed, 0.8, 0.06, 0.02), POSITIONS)
    readings = SENSOR.measured(truth.reactions * SCALE, np.random.default_rng([seed, 1]))
    rows = np.flatnonzero(~SENSOR.saturated(readings)[:, USED[method]].any(axis=1))
    recording = Recording(clamp=truth.clamp[rows], readings=readings[rows] / SCALE, line=rows)
    found = find_periods(known_setup(rod()), recording, DEVIATION, method=method, law="free")
    known = found.take(found.status == PeriodStatus.SLIP)
    mu0 = truth.mu0[rows[known.last]]
    covers = (known.low <= mu0) & (mu0 <= known.high)
    values = np.stack([known.mu0 - mu0, covers, known.deviation], axis=1)
    trailing = truth.period[rows[known.last]] == 1
    return {"trailing": values[trailing], "dragged": values[~trailing]}


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=200)
    seeds = range(parser.parse_args().seeds)
    print("| method | tip | slips | bias | rms error | predicted | coverage |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for method in WITH_ROD:
        gathered = defaultdict(list)
        for seed in seeds:
            for tip, values in one(seed, method).items():
                gathered[tip].append(values)
        for tip, values in gathered.items():
            error, covers, deviation = np.concatenate(values).T
            if not len(error):
                continue  # the spacing needs a slip before
            rms = np.sqrt(np.mean(error**2))
            print(
                f"| {method} | {tip} | {len(error)} | {error.mean():+.0e} | {rms:.1e} "
                f"| {deviation.mean():.1e} | {100.0 * covers.mean():.1f} % |"
            )


if __name__ == "__main__":
    main()

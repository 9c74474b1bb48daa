"""Friction of random surfaces from simulated signals: bias and coverage.

A steel whisker of 100 mm and 1 mm at the base (θ = 2, η = 0.85) moves 150 mm in steps of 50 µm over
a random texture (μ0 0.30 ± 0.04, correlated over 2 mm) and is read by an ATI Nano17 SI-12-0.12.
Where tolerances are adjusted, zeros and height are drawn from them.
"""

import argparse
import multiprocessing
from collections import defaultdict
from functools import cache

import numpy as np

from validation.records import write_record
from vibrissa.errors import VibrissaError
from vibrissa.mechanics.rod import Rod
from vibrissa.sensor import (
    PeriodStatus,
    Recording,
    SlipLaw,
    Units,
    Whisker,
    identify,
    path,
    preset,
    respond,
    simulate,
    surfaces,
)
from vibrissa.sensor.simulation.scanning import Outcome
from vibrissa.wording import markdown_table

ROD = Rod(youngs_modulus=2.1e11, base_diameter=1e-3, length=0.1)
SENSOR = preset("nano17-si-12-0.12")
SCALE = Units(ROD).channels
DEVIATION = np.array(SENSOR.deviation) / SCALE
THETA, ETA = 2.0, 0.85
POSITIONS = path("0.0005", ["1.5"])
RATIO = 0.8
# Standard deviations of the transducer's zero (N, N, N·m) and of the height (L), as drawn.
ZERO, HEIGHT = np.array([0.03, 0.03, 0.001]), 0.002
ADJUSTED = {
    "eta": HEIGHT,
    **dict(zip(("zero_force_x", "zero_force_y", "zero_moment_z"), ZERO / SCALE, strict=True)),
}
MODEL, WITHIN, RATIO_ALONE = "model", "model, height and zeros adjusted", "ratio"
CASES = (MODEL, WITHIN, RATIO_ALONE)
HEAD = (
    *("slips", "method", "ended early", "periods, found"),
    *("bias", "rms error", "predicted", "coverage"),
)


@cache
def rod():
    """Response of the rod, solved once in each process."""
    return respond(THETA, ETA)


def one(seed):
    """Scan one surface and identify it: what was found, by law and case."""
    surface = surfaces.random(seed, 0.3, 0.04, 0.02)
    drawn = np.random.default_rng([seed, 2])
    zero, near = drawn.normal(0.0, ZERO), ETA + float(drawn.normal(0.0, HEIGHT))
    results = {}
    for law in SlipLaw:
        truth = simulate(rod(), surface, POSITIONS, law, RATIO)

        def recorded(zero, truth=truth):
            reactions = truth.reactions * SCALE + zero
            readings = SENSOR.measured(reactions, np.random.default_rng([seed, 1])) / SCALE
            return Recording(clamp=truth.clamp, readings=readings, line=np.arange(len(truth)))

        asked = {"noise": DEVIATION, "assume": False}
        known, guessed = (Whisker(theta=THETA, eta=eta) for eta in (ETA, near))
        for name in CASES:
            try:
                if name == RATIO_ALONE:
                    found = identify(None, recorded(0.0), **asked).periods
                elif name == MODEL:
                    found = identify(known, recorded(0.0), **asked).periods
                else:
                    adjusted = {**asked, "tolerances": ADJUSTED}
                    found = identify(guessed, recorded(zero), **adjusted).periods
            except VibrissaError:
                continue  # refused: no state of this rod
            results[law, name] = outcome(truth, found)
    return results


def outcome(truth, found):
    """Errors, whether the intervals cover, deviations, their common part, and counts."""
    known = found.status == PeriodStatus.SLIP
    mu0 = truth.mu0[found.last][known]
    covers = (found.low[known] <= mu0) & (mu0 <= found.high[known])
    ended = truth.outcome is not Outcome.COMPLETE
    counts = int(truth.period[-1]), len(found.status), ended
    return (
        found.mu0[known] - mu0,
        covers,
        found.deviation[known],
        found.common[known],
        counts,
    )


def table(gathered):
    """Rows of the table."""
    for law in SlipLaw:
        for name in CASES:
            parts = gathered[law, name]
            error, covers, stated, common = (
                np.concatenate([part[i] for part in parts]) for i in range(4)
            )
            there, found, ended = np.sum([part[4] for part in parts], axis=0)
            size = f"{stated.mean():.1e}"
            if common.any():
                size += f" ({common.mean():.0e} correlated)"
            yield [
                str(law),
                name,
                str(ended),
                f"{there}, {found}",
                f"{error.mean():+.0e}",
                f"{np.sqrt((error**2).mean()):.1e}",
                size,
                f"{100.0 * covers.mean():.1f} %",
            ]


def main():
    """Print the table, and write the record."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--workers", type=int, default=None)
    parser.add_argument("--record", action="store_true", help="write the record")
    arguments = parser.parse_args()

    gathered = defaultdict(list)
    with multiprocessing.Pool(arguments.workers) as pool:
        for results in pool.imap_unordered(one, range(arguments.seeds), chunksize=5):
            for key, value in results.items():
                gathered[key].append(value)
    rows = f"{arguments.seeds} surfaces:\n\n{markdown_table(HEAD, table(gathered))}"
    print(rows)
    if arguments.record:
        write_record("roundtrip", __doc__, rows)

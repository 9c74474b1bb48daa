"""An error of the clamp positions that repeats along the way, as that of a lead screw does.

The pitch is not known. For each of many pitches P an error a·sin(2πX/P) + b·cos(2πX/P) of the
positions is fitted to the residuals, together with the contact points (Lomb, 1976).
"""

from dataclasses import dataclass

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.quantities.units import Kind, Units
from vibrissa.sensor.identification.fit import TINY, Fit
from vibrissa.sensor.identification.goodness import LEVEL, Cause

# Least number of blocks of samples in a pitch, and of pitches in the scan.
FINEST, FEWEST = 4.0, 4.0
# Waves that are tried for each additional wave in the scan, and the largest number of them.
FINER, MOST_TRIED = 4, 4000
# Least part of the misfit that the error must explain: slow waves explain a part of any misfit.
EXPLAINS = 0.5


@dataclass(frozen=True, kw_only=True)
class PitchError(Cause):
    """An error of the clamp positions that repeats; `size` is its amplitude (L).

    Attributes
    ----------
    pitch : float
        Distance after which the error repeats (L).
    """

    pitch: float

    def spelled(self, units: Units) -> str:
        """Format the error in the user's units."""
        length = units.unit(Kind.LENGTH)
        size, unit = units.told(self.size * length, Kind.LENGTH)
        error, _ = units.told(self.deviation * length, Kind.LENGTH)
        pitch, unit_of_pitch = units.told(self.pitch * length, Kind.LENGTH)
        return (
            f"positions of the clamp: an error of {size:.2g} ± {error:.1g} {unit} that repeats "
            f"every {pitch:.3g} {unit_of_pitch}, perhaps the pitch of a lead screw (explains "
            f"{self.explained:.0%} of the misfit)"
        )


def pitch_error_of(fit: Fit) -> PitchError | None:
    """Find an error of the positions that repeats and explains most of the misfit, if any."""
    blocks, excess = fit.task.blocks, fit.misfit - fit.degrees - fit.unevenness.number
    way, steps = np.ptp(blocks.clamp), np.abs(np.diff(blocks.clamp))
    if excess <= 0.0 or not steps.any():
        return None
    # Readings change along `slope` where positions are wrong.
    weight = np.where(fit.rows, (fit.slope**2).sum(axis=1), 0.0)
    miss = (fit.misses * fit.slope).sum(axis=1) / np.maximum(weight, TINY)
    most = way / (FINEST * np.median(steps[steps > 0.0]))
    number = int(np.clip(FINER * (most - FEWEST), 0, MOST_TRIED))
    waves = np.linspace(FEWEST, most, number)
    fits = [_fitted(fit, weight, miss, 2.0 * np.pi * wave / way) for wave in waves.tolist()]
    if not fits:
        return None
    best = int(np.argmax([fall for fall, _ in fits]))
    fall, size = fits[best]
    # Each wave has two coefficients: χ² of two degrees of freedom falls by more with exp(−fall/2).
    if number * np.exp(-0.5 * fall) > LEVEL or fall < EXPLAINS * excess:
        return None
    return PitchError(
        parameter=fit.task.parameters[fit.task.number["stage_scale"]],
        size=size,
        deviation=size / np.sqrt(fall),
        explained=min(fall / excess, 1.0),
        pitch=way / float(waves[best]),
    )


def _fitted(fit: Fit, weight: FloatArray, miss: FloatArray, number: float) -> tuple[float, float]:
    """Fit an error with this wave number (1/L); return the fall of χ², and the amplitude (L)."""
    blocks, phase = fit.task.blocks, number * fit.task.shown
    waves = np.stack([np.sin(phase), np.cos(phase)])
    whole = np.maximum(blocks.sums(weight), TINY)
    # The contact point of each period is fitted, too.
    waves -= np.stack([blocks.sums(weight * one) / whole for one in waves])[:, blocks.period]
    square = (weight * waves) @ waves.T
    along = waves @ (weight * miss)
    if np.linalg.det(square) <= 0.0:
        return 0.0, 0.0
    sizes = np.linalg.solve(square, along)
    return float(along @ sizes), float(np.hypot(*sizes))

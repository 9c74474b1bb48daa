"""An error of the clamp positions that repeats along the way, as that of a lead screw does.

The pitch is not known. For each of many pitches P an error a·sin(2πX/P) + b·cos(2πX/P) of the
positions is fitted to the residuals, together with the contact points (Lomb, 1976). The set-up has
been fitted before, and has taken a part of the error: for the best pitch, error and set-up are
fitted together, to first order.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.quantities.units import Kind, Units
from vibrissa.sensor.identification.fit import LEAST_WEIGHT, Fit
from vibrissa.sensor.identification.fitted_set_up import FittedSetUp
from vibrissa.sensor.identification.goodness import SIGNIFICANCE, Cause

# Least number of blocks of samples in a pitch.
FEWEST_BLOCKS = 4.0
# Least number of pitches in the scan.
FEWEST_PITCHES = 4.0
# Waves that are tried for each additional wave in the scan.
TRIED_PER_WAVE = 4
# Largest number of waves that are tried.
MOST_TRIED = 4000
# Least part of the misfit that the error must explain: slow waves explain a part of any misfit.
PITCH_EXPLAINS = 0.5


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
        size, unit = units.displayed(self.size * length, Kind.LENGTH)
        error, _ = units.displayed(self.deviation * length, Kind.LENGTH)
        pitch, unit_of_pitch = units.displayed(self.pitch * length, Kind.LENGTH)
        return (
            f"positions of the clamp: an error of {size:.2g} ± {error:.1g} {unit} that repeats "
            f"every {pitch:.3g} {unit_of_pitch}, perhaps the pitch of a lead screw (explains "
            f"{self.explained:.0%} of the misfit)"
        )


class _Normal(NamedTuple):
    """Normal equations of both coefficients of a wave.

    Attributes
    ----------
    square : ndarray, shape (2, 2)
        Half the second derivatives of χ² with respect to the coefficients.
    along : ndarray, shape (2,)
        Half the fall of χ² by each coefficient, to first order.
    """

    square: FloatArray
    along: FloatArray


class _Waves(NamedTuple):
    """Errors of the positions with m pitches, each fitted alone to the residuals.

    Attributes
    ----------
    fall : ndarray, shape (m,)
        Fall of χ² if the positions have this error.
    size : ndarray, shape (m,)
        Amplitude of the error (L).
    """

    fall: FloatArray
    size: FloatArray


def pitch_error_of(fitted: FittedSetUp) -> PitchError | None:
    """Find an error of the positions that repeats and explains most of the misfit, if any."""
    fit = fitted.fit
    degrees = fitted.degrees + fitted.unevenness.number
    blocks = fitted.task.blocks
    excess = fitted.misfit - degrees
    way = np.ptp(blocks.clamp)
    steps = np.abs(np.diff(blocks.clamp))
    if excess <= 0.0 or not steps.any():
        return None
    # Readings change along `slope` where positions are wrong.
    weight = np.where(fit.rows, (fit.slope**2).sum(axis=1), 0.0)
    along = np.where(fit.rows, (fitted.misses * fit.slope).sum(axis=1), 0.0)
    most = way / (FEWEST_BLOCKS * np.median(steps[steps > 0.0]))
    number = int(np.clip(TRIED_PER_WAVE * (most - FEWEST_PITCHES), 0, MOST_TRIED))
    if not number:
        return None
    waves = 2.0 * np.pi / way * np.linspace(FEWEST_PITCHES, most, number)
    alone = _fitted([_alone(fit, weight, along, wave) for wave in waves.tolist()])
    best = float(waves[np.argmax(alone.fall)])
    found = _fitted([_with_set_up(fitted, weight, best)])
    fall, size = float(found.fall[0]), float(found.size[0])
    # Each wave has two coefficients: χ² of two degrees of freedom falls by more with exp(−fall/2).
    if number * np.exp(-0.5 * fall) > SIGNIFICANCE or fall < PITCH_EXPLAINS * excess:
        return None
    left = max((fitted.misfit - fall) / max(degrees, 1), 1.0)
    return PitchError(
        parameter=fitted.task.parameters[fitted.task.number["stage_scale"]],
        size=size,
        deviation=size * np.sqrt(left / fall),
        explained=min(fall / excess, 1.0),
        pitch=2.0 * np.pi / best,
    )


def _waves(fit: Fit, weight: FloatArray, number: float) -> FloatArray:
    """Sine and cosine of the positions for a wave number (1/L), shape (2, n).

    Their part that only shifts the contact point of a period is subtracted, as that point is
    fitted, too.
    """
    blocks = fit.task.blocks
    phase = number * fit.task.shown
    waves = np.stack([np.sin(phase), np.cos(phase)])
    whole = np.maximum(blocks.sums(weight), LEAST_WEIGHT)
    means = blocks.sums((weight * waves).T).T / whole
    return np.asarray(waves - means[:, blocks.period])


def _alone(fit: Fit, weight: FloatArray, along: FloatArray, number: float) -> _Normal:
    """Set up the equations of an error with this wave number (1/L), for the fitted set-up."""
    waves = _waves(fit, weight, number)
    return _Normal(square=(weight * waves) @ waves.T, along=waves @ along)


def _with_set_up(fitted: FittedSetUp, weight: FloatArray, number: float) -> _Normal:
    """Set up the equations of an error and the set-up together, to first order."""
    fit = fitted.fit
    line = fitted.line
    waves = _waves(fit, weight, number)
    moved = [line.levelled(fit.slope * wave[:, None]) for wave in waves]
    changes = np.stack([change[fit.rows].ravel() for change in moved])
    square = changes @ changes.T
    if fitted.adjusted:
        shared = line.jacobian @ changes.T
        square -= shared.T @ fitted.remaining @ shared
    return _Normal(square=square, along=changes @ fitted.misses[fit.rows].ravel())


def _fitted(equations: Sequence[_Normal]) -> _Waves:
    """Solve the normal equations of several waves; one that cannot be told has the size 0."""
    square, along = (np.stack(each) for each in zip(*equations, strict=True))
    known = np.linalg.det(square) > 0.0
    square = np.where(known[:, None, None], square, np.eye(2))
    along = np.where(known[:, None], along, 0.0)
    sizes = np.linalg.solve(square, along[..., None])[..., 0]
    return _Waves(fall=(along * sizes).sum(axis=1), size=np.hypot(*sizes.T))

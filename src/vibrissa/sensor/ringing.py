"""How long a slip takes, how long the rod rings after it, and how fast the clamp may move."""

import math
from dataclasses import dataclass

import numpy as np

from vibrissa.outcomes import TipMotion
from vibrissa.sensor.whisker import Whisker
from vibrissa.sticking.curve import StickingCurve

# Damping ratio that is taken if none is stated: steel in a clamp has 0.001 to 0.01.
DAMPING = 0.01
# Part of its amplitude at which a vibration counts as over.
OVER = 0.01
# Duration of a slip in half waves of a tip that slides at α = 0. Slips of chains of links with mass
# take 1.0 to 1.5 of them (validation/records/slip-dynamics.md).
HALF_WAVES = 1.5


@dataclass(frozen=True, kw_only=True)
class Ringing:
    """Times of the vibrations of a rod that sticks and slips, in units of √(ρA0·L⁴/(E·I0)) or in s.

    Attributes
    ----------
    frequencies : tuple of float
        First two natural frequencies at the onset of slip while the tip sticks (periods per unit of
        time).
    slip : float
        Time that a slip takes.
    ring : float
        Time after which the first vibration of the sticking rod has fallen to 1 %.
    """

    frequencies: tuple[float, float]
    slip: float
    ring: float

    @property
    def lasts(self) -> float:
        """Time from the onset of a slip until the rod is at rest."""
        return self.slip + self.ring

    def in_seconds(self, frequency_unit: float) -> "Ringing":
        """Convert to Hz and s; `frequency_unit` is that of `vibrissa.Rod.frequency_unit`."""
        scale = 2.0 * math.pi * frequency_unit
        first, second = self.frequencies
        return Ringing(
            frequencies=(first * scale, second * scale),
            slip=self.slip / scale,
            ring=self.ring / scale,
        )


def ringing(curve: StickingCurve, x0: float, damping: float = DAMPING) -> Ringing:
    """Compute the vibrations of a rod whose tip slips at x0 (L).

    Parameters
    ----------
    curve : StickingCurve
    x0 : float
        Displacement at the onset of slip (L).
    damping : float
        Damping ratio ζ of the first vibration.

    Returns
    -------
    Ringing
        Times in units of √(ρA0·L⁴/(E·I0)); NaN where a frequency is not known.
    """
    first, second = curve.frequencies(x0, 2) / (2.0 * np.pi)
    (slides,) = curve.frequencies(0.0, 1, TipMotion.SLIDES) / (2.0 * np.pi)
    return Ringing(
        frequencies=(float(first), float(second)),
        slip=float(HALF_WAVES / (2.0 * slides)),
        ring=float(-math.log(OVER) / (2.0 * np.pi * damping * first)),
    )


def ringing_of(whisker: Whisker, x0: float, density: float | None) -> Ringing | None:
    """Compute the vibrations of a rod in Hz and s; None without a size or a density (kg/m³)."""
    if whisker.rod is None or density is None:
        return None
    return ringing(whisker.curve, x0).in_seconds(whisker.rod.frequency_unit(density))

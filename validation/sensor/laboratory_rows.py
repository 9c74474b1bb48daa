"""Set-up errors of the table of `laboratory`, and the tolerances that are stated for them."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from validation.sensor.mistakes import UNITS

DEGREE = np.pi / 180.0


class Said(StrEnum):
    """Tolerances that are given for a set-up error.

    Attributes
    ----------
    NOTHING
        The default tolerances. The error has a fixed size, with alternating sign.
    ENOUGH
        The size of the error is its tolerance, one standard deviation, and the error is drawn from
        this distribution. Everything else is stated to be exact.
    LITTLE
        A tenth of the error's fixed size is its tolerance. Everything else is stated to be exact.
    """

    NOTHING = "default"
    ENOUGH = "right"
    LITTLE = "small"


@dataclass(frozen=True, kw_only=True)
class Row:
    """A set-up error of the table.

    Attributes
    ----------
    title : str
    sizes : mapping of str to float
        Sizes of errors by their names in `MISTAKES`; all of them occur together.
    surface : float
        Inclination of the surface against clamp, stage and transducer (rad).
    on_the_way : bool
        Whether the tip slips while the stage moves, and not while it rests.
    all_at_once : bool
        Whether all errors occur, drawn from the default tolerances.
    forces_alone : bool
        Whether the moment is not recorded.
    encoder : float
        Standard deviation of the recorded positions (L), which the laboratory does not state.
    without_rod : bool
        Whether the laboratory does not state the rod.
    """

    title: str
    sizes: Mapping[str, float]
    surface: float = 0.0
    on_the_way: bool = False
    all_at_once: bool = False
    forces_alone: bool = False
    encoder: float = 0.0
    without_rod: bool = False

    @property
    def tolerances(self):
        """Standard deviations, by tolerance, that equal the size of the error."""
        angles = dict.fromkeys(("clamp_angle", "stage_angle", "transducer_angle"), self.surface)
        return {**self.sizes, **(angles if self.surface else {})}

    @property
    def ways(self):
        """Tolerances with which the table shows this error."""
        if self.all_at_once:
            return [Said.NOTHING]
        # Without a rod, a wrong tolerance of a zero cannot be noticed.
        some = [Said.NOTHING, Said.ENOUGH]
        return list(Said) if self.tolerances and not self.without_rod else some

    def contained(self, said):
        """Return whether the tolerances allow for the error."""
        if said is Said.LITTLE:
            return False
        return said is Said.ENOUGH or self.all_at_once or not self.tolerances


def _one(title, name, size):
    return Row(title=title, sizes={name: size})


_DRIFT = 0.02 / UNITS[0]
ROWS = (
    Row(title="nothing", sizes={}),
    Row(title="everything, drawn from what is assumed", sizes={}, all_at_once=True),
    _one("clamp inclined by 2°", "clamp_angle", 2.0 * DEGREE),
    _one("clamp inclined by 0.5°", "clamp_angle", 0.5 * DEGREE),
    _one("E 5 % off", "modulus", 0.05),
    _one("E 1 % off", "modulus", 0.01),
    _one("θ 2.1 for 2", "theta", 0.1),
    _one("θ 2.02 for 2", "theta", 0.02),
    _one("η 1 % off", "eta", 0.0085),
    _one("clamp yields by 0.5°", "clamp_compliance", 0.018),
    _one("rod bent by 1 % of its length", "curvature", 0.08),
    _one("moment taken 1 mm beside", "moment_origin_x", 0.01),
    _one("moment taken 1 mm below", "moment_origin_y", 0.01),
    Row(title="surface inclined by 0.5°", sizes={}, surface=0.5 * DEGREE),
    _one("transducer turned by 1°", "transducer_angle", DEGREE),
    _one("transducer turned by 0.3°", "transducer_angle", 0.3 * DEGREE),
    _one("crosstalk 1 %", "crosstalk", 0.01),
    _one("stage scale 1 % off", "stage_scale", 0.01),
    Row(
        title="zeros of both forces drift by 20 mN",
        sizes={"drift_force_x": _DRIFT, "drift_force_y": _DRIFT},
    ),
    Row(
        title="the same, no moment recorded",
        sizes={"drift_force_x": _DRIFT, "drift_force_y": _DRIFT},
        forces_alone=True,
    ),
    _one("slope of the surface ±1° over 30 mm", "surface_slope", 0.0123),
    Row(title="tip slips while the stage moves", sizes={}, on_the_way=True),
    _one("E falls by 1 % per decade of time", "creep", 0.01),
    Row(title="positions with a noise of 5 µm", sizes={}, encoder=5e-5),
    Row(
        title="channels not tared, 60 mN, no rod",
        sizes={"zero_force_x": _DRIFT * 3.0},
        forces_alone=True,
        without_rod=True,
    ),
)


def sign_of(seed):
    """Return the sign of an error of fixed size, which alternates with the seed."""
    return 1.0 if seed % 2 else -1.0

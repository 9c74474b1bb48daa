"""The response of a rod: clamp reactions over the displacement x0, where the clamp pushes or pulls.

In pulling (x0 < 0) the response reaches as far as the path was solved.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline, PPoly

from vibrissa.errors import NoResponseError
from vibrissa.mechanics.mounting import IDEAL
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import End, Status
from vibrissa.sensor.whisker import Whisker
from vibrissa.sticking.api import solve_curves
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.piece import Pieces

# Number of knots on each smooth piece of the curve; the error of the spline is about 1e-9.
KNOTS = 641
# Least normal force that is not 0 (E·I0/L²).
TINY = 1e-9


class States(ABC):
    """States of a rod as functions of x0, all at one height, or each at its own height.

    Attributes
    ----------
    x0_pull, x0_lock, x0_end : float or ndarray
        Displacements at which pulling ends (0 without pulling), the tip locks, and pushing ends
        (L).
    x1_init : float or ndarray
        Contact point in the α = 0 state, from the clamp (L).
    bounds : ndarray
        Displacements between which the reactions at one height are smooth: end of pulling, kinks,
        α = 0, lock, end of pushing (L).
    """

    x0_pull: ArrayLike
    x0_lock: ArrayLike
    x0_end: ArrayLike
    x1_init: ArrayLike
    bounds: FloatArray

    @abstractmethod
    def derivative(self, x0: ArrayLike, order: int) -> FloatArray:
        """Differentiate fx, fy and m `order` times with respect to x0, shape x0.shape + (3,)."""

    def __call__(self, x0: ArrayLike) -> FloatArray:
        """Clamp reactions fx, fy and m at displacements, shape x0.shape + (3,)."""
        return self.derivative(x0, 0)

    def slope(self, x0: ArrayLike) -> FloatArray:
        """Differentiate the clamp reactions with respect to x0, shape x0.shape + (3,)."""
        return self.derivative(x0, 1)

    def clip(self, x0: ArrayLike) -> FloatArray:
        """Clip displacements to those with known states (L)."""
        return np.clip(x0, self.x0_pull, self.x0_end)

    def demand(self, x0: ArrayLike) -> FloatArray:
        """Friction coefficient −tan α that the tip needs to stick; negative where it is pulled."""
        fx, fy, _ = np.moveaxis(self(x0), -1, 0)
        return np.asarray(fx / fy)

    def demand_slope(self, x0: ArrayLike) -> FloatArray:
        """Differentiate −tan α with respect to x0 (1/L)."""
        fx, fy, _ = np.moveaxis(self(x0), -1, 0)
        fx_slope, fy_slope, _ = np.moveaxis(self.slope(x0), -1, 0)
        return np.asarray((fx_slope * fy - fx * fy_slope) / fy**2)

    @property
    def mu_lock(self) -> float:
        """Largest friction at which a pushed tip slips; infinite if it lifts off instead."""
        fx, fy, _ = self(self.x0_lock)
        return float(fx / fy) if fy < -TINY else float("inf")

    def contact(self, clamp: float, x0: float, side: int) -> float:
        """Position of the tip (L), which is ahead of the clamp (`side` 1) or behind it (−1).

        The state of a tip behind the clamp is the mirror image of the state at x0.
        """
        return float(clamp + side * (np.asarray(self.x1_init) - x0))


@dataclass(frozen=True, eq=False, kw_only=True)
class Response(States):
    """Clamp reactions of one rod at one height over the displacement x0 of the clamp.

    Attributes
    ----------
    reactions : PPoly
        fx, fy (E·I0/L²) and m (E·I0/L) over x0, from where pulling ends to where pushing ends.
    swings : bool
        Whether a locked tip is dragged after the end of pushing: the rod buckles laterally, its
        mounting is ideal, and its retraction was solved.
    curve : StickingCurve
        The sticking curve that was tabulated.
    """

    reactions: PPoly
    x0_pull: float
    x0_lock: float
    x0_end: float
    x1_init: float
    bounds: FloatArray
    swings: bool
    curve: StickingCurve

    @property
    def lock(self) -> int:
        """Index in `bounds` of the displacement at which the tip locks."""
        return int(np.argmin(np.abs(self.bounds - self.x0_lock)))

    def derivative(self, x0: ArrayLike, order: int) -> FloatArray:
        """Differentiate fx, fy and m `order` times with respect to x0, shape x0.shape + (3,)."""
        return np.asarray(self.reactions(x0, order))


def responses(whiskers: Sequence[Whisker], partly: bool = False) -> list[Response]:
    """Solve and tabulate the responses of several whiskers, of any θ, η and mounting.

    Parameters
    ----------
    partly : bool
        Whether to accept curves that were not followed to their end.

    Raises
    ------
    NoResponseError
        If one of the curves was not solved, or a stage is oblique.
    ArgumentError
        If an argument is out of range.
    """
    for whisker in whiskers:
        if angle := whisker.mounting.stage_angle:
            raise NoResponseError(
                "stage_angle must be 0 for one response: an oblique stage begins each period at "
                f"another height, see vibrissa.sensor.Whisker.stage; got {angle!r}"
            )
    one, mountings = whiskers[0], [whisker.mounting for whisker in whiskers]
    theta, eta = [whisker.theta for whisker in whiskers], [whisker.eta for whisker in whiskers]
    curves = solve_curves(theta, eta, one.contact, mountings, one.section, retract=True)
    for curve in curves:
        if not (curve.status is Status.SOLVED or (partly and curve.pieces)):
            raise NoResponseError(f"the sticking curve is {curve.status}: {curve.message}")
    return [tabulated(curve) for curve in curves]


def tabulated(curve: StickingCurve) -> Response:
    """Tabulate the response of a solved curve, with its retraction if that was solved."""
    pieces = Pieces.concatenate([curve.retraction, curve.pieces])
    parts: list[PPoly] = []
    for number, begin in enumerate(pieces.first_x0):
        # Equal steps of the piece's parameter: near a limit point they are short in x0.
        t = np.linspace(pieces.start[number], pieces.stop[number], KNOTS)
        states = pieces.at(np.full(KNOTS, number), t)
        # The first x0 of a piece is taken without rounding, so that a piece contains x0 = 0.
        x0 = np.append(begin, states.x0[1:])
        loads = [states.reaction_fx, states.reaction_fy, states.reaction_m]
        parts.append(CubicSpline(x0, np.stack(loads, axis=-1)))
    reactions = PPoly(
        np.concatenate([part.c for part in parts], axis=1),
        np.concatenate([*(part.x[:-1] for part in parts), parts[-1].x[-1:]]),
        extrapolate=False,
    )
    kinks = pieces.first_x0[1:][np.diff(pieces.line)]
    x0_pull, x0_end = float(reactions.x[0]), float(reactions.x[-1])
    # On a curve that ends before a lock, −tan α is largest at its end.
    x0_lock = curve.x0_lock if np.isfinite(curve.x0_lock) else x0_end
    # Only in an ideal mounting is the mirror image of a state a state of the rod, too.
    dragged = len(curve.retraction) > 0 and curve.mounting == IDEAL
    return Response(
        reactions=reactions,
        x0_pull=x0_pull,
        x0_lock=x0_lock,
        x0_end=x0_end,
        x1_init=curve.x1_init,
        bounds=np.unique([x0_pull, 0.0, *kinks, x0_lock, x0_end]),
        swings=dragged and curve.end is End.SWINGS_ASIDE,
        curve=curve,
    )

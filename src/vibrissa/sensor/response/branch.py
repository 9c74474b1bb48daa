"""The response of a rod: clamp reactions over the displacement x0.

The clamp pushes the tip for x0 > 0, and pulls it for x0 < 0. States with x0 < 0 are known only
as far as they were solved.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

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
# Pieces that are not longer are left out: their knots would coincide (L).
SHORTEST = 1e-8
# Least normal force that is not 0 (E·I0/L²).
TINY = 1e-9


class States(ABC):
    """Sticking states of a rod as functions of x0, all at one height, or each at its own height.

    Attributes
    ----------
    x0_pull, x0_end : float or ndarray
        Least and largest displacement at which the states are known (L): the end of pulling, which
        is 0 without pulling, and the end of pushing.
    x0_lock : float or ndarray
        Displacement at which the tip locks: −tan α is largest (L).
    x1_init : float or ndarray
        Contact point in the α = 0 state, measured from the clamp (L).
    bounds : ndarray
        Landmarks, between which the reactions at one height are smooth: x0_pull, kinks where the
        rod changes between tip and line contact, x0 = 0, x0_lock and x0_end (L).
    """

    x0_pull: Any
    x0_lock: Any
    x0_end: Any
    x1_init: Any
    bounds: FloatArray

    @abstractmethod
    def derivative(self, x0: ArrayLike, order: int) -> FloatArray:
        """Differentiate fx, fy and m once (`order` 1) or not (0) by x0, shape x0.shape + (3,)."""

    def __call__(self, x0: ArrayLike) -> FloatArray:
        """Clamp reactions fx, fy and m at displacements, shape x0.shape + (3,)."""
        return self.derivative(x0, 0)

    def slope(self, x0: ArrayLike) -> FloatArray:
        """Differentiate the clamp reactions with respect to x0, shape x0.shape + (3,)."""
        return self.derivative(x0, 1)

    def clip(self, x0: ArrayLike) -> FloatArray:
        """Clip displacements to the range in which the states are known (L)."""
        return np.clip(x0, self.x0_pull, self.x0_end)

    def demand(self, x0: ArrayLike) -> FloatArray:
        """Return the mobilised friction −tan α, which the tip needs to stick.

        It is negative where the clamp pulls the tip.
        """
        fx, fy, _ = np.moveaxis(self(x0), -1, 0)
        return np.asarray(fx / fy)

    def demand_slope(self, x0: ArrayLike) -> FloatArray:
        """Differentiate −tan α with respect to x0 (1/L)."""
        fx, fy, _ = np.moveaxis(self(x0), -1, 0)
        fx_slope, fy_slope, _ = np.moveaxis(self.slope(x0), -1, 0)
        return np.asarray((fx_slope * fy - fx * fy_slope) / fy**2)

    @property
    def mu_lock(self) -> float:
        """Largest μ0 at which a pushed tip slips; infinite if it lifts off instead of locking."""
        fx, fy, _ = self(self.x0_lock)
        return float(fx / fy) if fy < -TINY else float("inf")

    def contact(self, clamp: float, x0: float, side: int) -> float:
        """Return the position of the tip along the surface (L) for a clamp position (L).

        The tip is ahead of the clamp (`side` 1), or behind it (−1): then the state is the mirror
        image of the one at `x0`.
        """
        return float(clamp + side * (np.asarray(self.x1_init) - x0))


@dataclass(frozen=True, eq=False, kw_only=True)
class Response(States):
    """Clamp reactions of one rod at one height, as functions of the displacement x0 of the clamp.

    Attributes
    ----------
    reactions : PPoly
        fx, fy (E·I0/L²) and m (E·I0/L) over x0, from x0_pull to x0_end.
    kinks : ndarray
        Displacements at which the kind of contact changes (L).
    swings : bool
        Whether the rod buckles laterally at x0_end, and the tip can then be followed while it is
        dragged behind the clamp: the mounting is ideal, and states with x0 < 0 were solved.
    curve : StickingCurve
        The sticking curve that was tabulated.
    """

    reactions: PPoly
    x0_pull: float
    x0_lock: float
    x0_end: float
    x1_init: float
    bounds: FloatArray
    kinks: FloatArray
    swings: bool
    curve: StickingCurve

    def derivative(self, x0: ArrayLike, order: int) -> FloatArray:
        """Differentiate fx, fy and m `order` times with respect to x0, shape x0.shape + (3,)."""
        return np.asarray(self.reactions(x0, order))


def responses(whiskers: Sequence[Whisker], partly: bool = False) -> list[Response]:
    """Solve and tabulate the responses of several whiskers, whose θ, η and mountings may differ.

    Parameters
    ----------
    whiskers : sequence of Whisker
        Whiskers of the same `contact` and the same `section`.
    partly : bool
        Whether to accept curves that the solver did not follow to their end.

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
                f"a response at one height needs stage_angle 0, got {angle!r}: on an oblique stage "
                "the height changes (see vibrissa.sensor.Whisker.stage)"
            )
    one, mountings = whiskers[0], [whisker.mounting for whisker in whiskers]
    theta, eta = [whisker.theta for whisker in whiskers], [whisker.eta for whisker in whiskers]
    curves = solve_curves(theta, eta, one.contact, mountings, one.section, retract=True)
    for curve in curves:
        if not (curve.status is Status.SOLVED or (partly and curve.pieces)):
            raise NoResponseError(f"the sticking curve has status {curve.status}: {curve.message}")
    return [tabulated(curve) for curve in curves]


def tabulated(curve: StickingCurve) -> Response:
    """Tabulate the response of a solved curve, with its states at x0 < 0 if it has any."""
    pieces = Pieces.concatenate([curve.retraction, curve.pieces])
    pieces = pieces.take(pieces.last_x0 - pieces.first_x0 > SHORTEST)
    parts: list[PPoly] = []
    for number, begin in enumerate(pieces.first_x0):
        # Equal steps of the piece's parameter: near a limit point they are short in x0.
        t = np.linspace(pieces.start[number], pieces.stop[number], KNOTS)
        states = pieces.at(np.full(KNOTS, number), t)
        # The first x0 of a piece is taken without rounding, so that a piece contains x0 = 0.
        x0 = np.append(begin, states.x0[1:])
        loads = np.stack([states.reaction_fx, states.reaction_fy, states.reaction_m], axis=-1)
        # The end of a retraction may be a little past a limit point.
        first = 0 if number else int(np.flatnonzero(np.diff(x0, prepend=np.inf) <= 0.0)[-1])
        parts.append(CubicSpline(x0[first:], loads[first:]))
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
        kinks=kinks,
        swings=dragged and curve.end is End.SWINGS_ASIDE,
        curve=curve,
    )

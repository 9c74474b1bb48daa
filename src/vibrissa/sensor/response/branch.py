"""The rod's response: clamp reactions at every displacement x0 of the clamp, pulled or pushed.

Where the clamp pulls (x0 < 0), it ends at the state without normal force (fy = 0).
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline, PPoly
from scipy.optimize import brentq

from vibrissa.errors import NoResponseError
from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.mechanics.states import ContactState
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.splines import joined
from vibrissa.outcomes import Contact, End, RodSection, Status
from vibrissa.sensor.response.pulled import Pulled
from vibrissa.sensor.whisker import Whisker
from vibrissa.sticking.api import solve_curves
from vibrissa.sticking.curve import StickingCurve

# Knots on each smooth piece of the curve; the spline between them is good to about 1e-9.
KNOTS = 641
# A normal force below this is none (E·I0/L²).
TINY = 1e-9


class States(ABC):
    """States of a rod by the displacement x0: of one branch, or each at a height of its own."""

    @abstractmethod
    def __call__(self, x0: ArrayLike) -> FloatArray:
        """Clamp reactions fx, fy and m at displacements, shape x0.shape + (3,)."""

    @abstractmethod
    def slope(self, x0: ArrayLike) -> FloatArray:
        """Differentiate the clamp reactions with respect to x0, shape x0.shape + (3,)."""

    def demand(self, x0: ArrayLike) -> FloatArray:
        """Friction coefficient −tan α that the tip needs to stick; negative where it is pulled."""
        fx, fy, _ = np.moveaxis(self(x0), -1, 0)
        return np.asarray(fx / fy)

    def demand_slope(self, x0: ArrayLike) -> FloatArray:
        """Differentiate the demand with respect to the displacement (1/L)."""
        fx, fy, _ = np.moveaxis(self(x0), -1, 0)
        fx_slope, fy_slope, _ = np.moveaxis(self.slope(x0), -1, 0)
        return np.asarray((fx_slope * fy - fx * fy_slope) / fy**2)


@dataclass(frozen=True, eq=False, kw_only=True)
class Branch(States):
    """Clamp reactions over the displacement x0 of the clamp.

    Attributes
    ----------
    reactions : PPoly
        fx, fy (E·I0/L²) and m (E·I0/L) over x0, from where pulling ends to where pushing ends.
    x0_lock : float
        Displacement at which the tip locks (L).
    x1_init : float
        Contact point in the α = 0 state, from the clamp (L).
    bounds : ndarray
        Ends of the smooth stretches: where pulling ends, kinks, α = 0, the lock, the end (L).
    swings : bool
        Whether a locked tip is dragged in the end: pushing ends with lateral buckling, and
        retraction is resolved.
    """

    reactions: PPoly
    x0_lock: float
    x1_init: float
    bounds: FloatArray
    swings: bool

    @property
    def x0_pull(self) -> float:
        """Where pulling ends, as the normal force vanishes (L); 0 without pulling."""
        return float(self.reactions.x[0])

    @property
    def x0_end(self) -> float:
        """Where pushing ends (L)."""
        return float(self.reactions.x[-1])

    @property
    def mu_lock(self) -> float:
        """Largest friction at which a pushed tip slips; infinite if it lifts off instead."""
        fx, fy, _ = self.reactions(self.x0_lock)
        return float(fx / fy) if fy < -TINY else float("inf")

    def __call__(self, x0: ArrayLike) -> FloatArray:
        """Clamp reactions fx, fy and m at displacements on the branch, shape x0.shape + (3,)."""
        return np.asarray(self.reactions(x0))

    def contact(self, clamp: float, x0: float, side: int) -> float:
        """Position of the tip (L), which is ahead of the clamp (`side` 1) or behind it (−1).

        Behind it the state is the mirror image of that at x0.
        """
        return clamp - side * x0 + side * self.x1_init

    def clip(self, x0: ArrayLike) -> FloatArray:
        """Nearest displacements on the branch (L)."""
        return np.clip(x0, self.x0_pull, self.x0_end)

    def slope(self, x0: ArrayLike) -> FloatArray:
        """Differentiate the clamp reactions with respect to x0, shape x0.shape + (3,)."""
        return np.asarray(self.reactions(x0, 1))


@dataclass(frozen=True, eq=False, kw_only=True)
class Response(Branch):
    """Branch of one rod at one height, with the sticking curve from which it was tabulated.

    Attributes
    ----------
    curve : StickingCurve
        Sticking curve, which covers x0 ≥ 0.
    """

    curve: StickingCurve

    @cached_property
    def _descent(self) -> tuple[FloatArray, FloatArray]:
        """Knots from 0 down to where pulling ends, and the largest tan α so far."""
        x = self.reactions.x[self.reactions.x <= 0.0][::-1]
        fx, fy, _ = self(x).T
        tan = np.divide(-fx, fy, out=np.full_like(fx, np.inf), where=fy < 0.0)
        return x, np.maximum.accumulate(tan)

    def push_limit(self, mu0: float) -> tuple[float, bool]:
        """Largest x0 up to which a pushed tip sticks, and whether it is past the lock (L)."""
        if mu0 > self.curve.mu_lock:
            _, state = self.curve.motion_end(mu0)
            end = float(state.x0[0])
            # If the motion was not followed past the lock, nothing is known beyond the lock.
            return (end if np.isfinite(end) else self.curve.x0_lock), True
        return float(self.curve.onset(mu0)), False

    def pull_limit(self, mu0: float) -> float:
        """Least x0 down to which a pulled tip sticks (L); −infinity without pulling."""
        if self.x0_pull == 0.0:
            return -np.inf
        x, demand = self._descent
        after = int(np.clip(np.searchsorted(demand, mu0), 1, len(x) - 1))

        def excess(x0: float) -> float:
            fx, fy, _ = self.reactions(x0)
            return float(mu0 * fy + fx)

        low, high = float(x[after - 1]), float(x[after])
        if excess(low) * excess(high) >= 0.0:  # a root at an end, up to rounding
            return low if abs(excess(low)) < abs(excess(high)) else high
        return float(brentq(excess, low, high, xtol=1e-14))


def respond(
    theta: float,
    eta: float,
    contact: Contact | str = Contact.POINT,
    pull: bool = True,
    mounting: Mounting = IDEAL,
    section: RodSection | str = RodSection.ROUND,
) -> Response:
    """Solve and tabulate the response of one rod at one height.

    Parameters
    ----------
    theta : float
        Taper factor, at least 1.
    eta : float
        Height of the contact point, 0 < eta < 1 (L).
    contact : str
        ``point`` or ``line``, as in `vibrissa.solve_state`.
    pull : bool
        Whether to continue the curve to x0 < 0, where the clamp pulls.
    mounting : Mounting
    section : str
        ``round`` or ``planar``, as in `vibrissa.solve_curve`.

    Returns
    -------
    Response

    Raises
    ------
    NoResponseError
        If the curve was not solved, or not continued to x0 < 0, or the stage is oblique.
    ArgumentError
        If an argument is out of range.
    """
    whisker = Whisker(
        theta=theta,
        eta=eta,
        contact=Contact(contact),
        section=RodSection(section),
        mounting=mounting,
    )
    return responses([whisker], pull)[0]


def responses(whiskers: Sequence[Whisker], pull: bool, partly: bool = False) -> list[Response]:
    """Solve and tabulate the responses of whiskers together, which differ in θ, η and mounting.

    Parameters
    ----------
    pull : bool
        Whether to continue the curves to x0 < 0, where the clamp pulls.
    partly : bool
        Whether a curve that ends early does.

    Raises
    ------
    NoResponseError
        If one of the curves was not solved, or not continued to x0 < 0, or a stage is oblique.
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
    curves = solve_curves(theta, eta, one.contact, mountings, one.section)
    for curve in curves:
        if not (curve.status is Status.SOLVED or (partly and curve.pieces)):
            raise NoResponseError(f"the sticking curve is {curve.status}: {curve.message}")
    pulled = Pulled(curves, Contact(one.contact)).splines(KNOTS) if pull else [[] for _ in curves]
    return [tabulated(curve, parts) for curve, parts in zip(curves, pulled, strict=True)]


def tabulated(curve: StickingCurve, pulled: Sequence[PPoly] = ()) -> Response:
    """Tabulate the response of a solved curve.

    Parameters
    ----------
    pulled : sequence of PPoly
        Reactions at x0 < 0, if they are known.
    """
    parts: list[PPoly] = list(pulled)
    for piece in curve.pieces:
        # Equal steps of the piece's parameter: near a limit point they are short in x0.
        states = piece.at(np.linspace(piece.start, piece.stop, KNOTS))
        # A piece begins where it says, not beside it by rounding: x0 = 0 lies in the first one.
        x0 = np.append(piece.first_x0, states.x0[1:])
        parts.append(CubicSpline(x0, _reactions(states)))
    reactions = joined(parts)
    kinks = [b.first_x0 for a, b in pairwise(curve.pieces) if a.contact is not b.contact]
    ends = [part.x[0] for part in parts[: -len(curve.pieces)]]
    # A curve that ends before a lock has its most there.
    x0_lock = curve.x0_lock if np.isfinite(curve.x0_lock) else float(reactions.x[-1])
    bounds = np.unique([*ends, 0.0, *kinks, x0_lock, reactions.x[-1]])
    return Response(
        reactions=reactions,
        x0_lock=x0_lock,
        x1_init=curve.x1_init,
        bounds=bounds,
        # The mirror image of a mounted rod is not a state of it.
        swings=curve.end is End.SWINGS_ASIDE and curve.mounting == IDEAL and bool(pulled),
        curve=curve,
    )


def _reactions(state: ContactState) -> FloatArray:
    """Reactions of many states, in rows."""
    return np.stack([state.reaction_fx, state.reaction_fy, state.reaction_m], axis=-1)

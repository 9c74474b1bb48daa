"""The response of a rod: its states as functions of the displacement x0, at one distance η.

The clamp pushes the tip for x0 > 0, and pulls it for x0 < 0. States with x0 < 0 are known only
as far as they were solved.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.errors import NoResponseError
from vibrissa.mechanics.shape import Shape
from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.numerics.steps import ONSET_ACCURACY
from vibrissa.outcomes import Contact, End, Status
from vibrissa.scanning.rods import MountedRod
from vibrissa.sticking.api import solve_curves
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.piece import Pieces, StickingState

# Components of the load on the clamp, in their order in arrays.
LOADS = ("reaction_fx", "reaction_fy", "reaction_m")
TIP_ANGLE = ("phi1",)
# Pieces that are not longer are left out: in rounded numbers they have no inside (L).
SHORTEST_PIECE = 1e-8
# Least normal force that is not 0 (E·I0/L²).
LEAST_FORCE = 1e-9


def mirrored_loads(loads: FloatArray, side: IntArray) -> FloatArray:
    """Mirror loads fx, fy and m, shape (n, 3), where the tip is behind the clamp (`side` −1)."""
    mirror = np.stack([side, np.ones(len(side)), side], axis=1)
    return np.asarray(loads * mirror)


class States(ABC):
    """Sticking states of a rod as functions of x0, at one distance η or each at one of its own.

    Attributes
    ----------
    x0_pull, x0_end : float or ndarray
        Least and largest displacement at which the states are known (L): the end of pulling, which
        is 0 without pulling, and the end of pushing.
    x0_lock : float or ndarray
        Displacement at which −tan α is largest (L).
    x1_init : float or ndarray
        Contact point in the α = 0 state, measured from the clamp (L).
    bounds : ndarray
        Landmarks, between which the reactions at one distance are smooth: x0_pull, kinks where the
        rod changes between tip and line contact, x0 = 0, x0_lock and x0_end (L).
    accuracy : float
        Error of the displacement at which sticking ends (L). A step that ends this close to it
        counts as ending on it.
    """

    x0_pull: Any
    x0_lock: Any
    x0_end: Any
    x1_init: Any
    bounds: Any
    accuracy: float

    @abstractmethod
    def derivative(self, x0: ArrayLike, order: int) -> FloatArray:
        """Differentiate fx, fy and m once (`order` 1) or not (0) by x0, shape x0.shape + (3,)."""

    @abstractmethod
    def tip_angle(self, x0: ArrayLike) -> FloatArray:
        """Slope angle φ1 of the rod at its tip, at displacements (rad), shape x0.shape."""

    @abstractmethod
    def state(self, x0: FloatArray) -> StickingState:
        """Return the states at displacements, with all their columns; see `StickingState`."""

    @abstractmethod
    def shapes(self, x0: FloatArray, offset: FloatArray, s: FloatArray) -> Shape:
        """Deformed shapes, with the clamp at the origin and the tip ahead of it.

        Parameters
        ----------
        x0, offset : ndarray, shape (n,)
            Displacement, and distance of the tip ahead of the clamp (L).
        s : ndarray, shape (points,)
            Arc lengths between 0 and 1, increasing (L).
        """

    def reactions(self, x0: ArrayLike) -> FloatArray:
        """Clamp reactions fx, fy and m at displacements, shape x0.shape + (3,)."""
        return self.derivative(x0, 0)

    def reactions_slope(self, x0: ArrayLike) -> FloatArray:
        """Differentiate the clamp reactions with respect to x0, shape x0.shape + (3,)."""
        return self.derivative(x0, 1)

    def clip(self, x0: ArrayLike) -> FloatArray:
        """Clip displacements to the range in which the states are known (L)."""
        return np.clip(x0, self.x0_pull, self.x0_end)

    def demand(self, x0: ArrayLike) -> FloatArray:
        """Return the mobilised friction −tan α, which the tip needs to stick.

        It is negative where the clamp pulls the tip.
        """
        fx, fy, _ = np.moveaxis(self.reactions(x0), -1, 0)
        return np.asarray(fx / fy)

    def demand_slope(self, x0: ArrayLike) -> FloatArray:
        """Differentiate −tan α with respect to x0 (1/L)."""
        fx, fy, _ = np.moveaxis(self.reactions(x0), -1, 0)
        fx_slope, fy_slope, _ = np.moveaxis(self.reactions_slope(x0), -1, 0)
        return np.asarray((fx_slope * fy - fx * fy_slope) / fy**2)

    @property
    def mu_lock(self) -> float:
        """Largest μ0 at which a pushed tip slips; infinite if it lifts off instead of locking."""
        fx, fy, _ = self.reactions(self.x0_lock)
        return float(fx / fy) if fy < -LEAST_FORCE else float("inf")

    def contact(self, clamp: float, x0: float, side: int) -> float:
        """Return the position of the tip along the surface (L) for a clamp position (L).

        The tip is ahead of the clamp (`side` 1), or behind it (−1): then the state is the mirror
        image of the one at `x0`.
        """
        return float(clamp + side * (np.asarray(self.x1_init) - x0))


@dataclass(frozen=True, eq=False, kw_only=True)
class Response(States):
    """States of one rod at one distance: a view on its sticking curve, from pulling to pushing.

    Attributes
    ----------
    curve : StickingCurve
        A curve with states.
    """

    curve: StickingCurve
    accuracy: float = ONSET_ACCURACY

    @cached_property
    def pieces(self) -> Pieces:
        """Pieces of the curve in the order of x0, those of the retraction first."""
        pieces = Pieces.concatenate([self.curve.retraction, self.curve.pieces])
        pieces = pieces.take(pieces.last_x0 - pieces.first_x0 > SHORTEST_PIECE)
        turn = int(pieces.samples.x0[0].argmin())
        if turn == 0:
            return pieces
        # The retraction was followed a little past a limit point, where x0 turns.
        first, others = pieces.take(slice(1)), pieces.take(slice(1, None))
        begin = pieces.sample_places[:1, turn]
        return Pieces.concatenate([first.cut_to(begin, first.stop), others])

    @cached_property
    def x0_pull(self) -> float:
        """See `States`."""
        return float(self.pieces.first_x0[0])

    @cached_property
    def x0_end(self) -> float:
        """See `States`."""
        return float(self.pieces.last_x0[-1])

    @property
    def x0_lock(self) -> float:
        """See `States`; on a curve that ends before a lock, −tan α is largest at its end."""
        return self.curve.x0_lock if np.isfinite(self.curve.x0_lock) else self.x0_end

    @property
    def x1_init(self) -> float:
        """See `States`."""
        return self.curve.x1_init

    @property
    def x0_through(self) -> float:
        """Displacement from which on the rod passes through the surface (L).

        Infinite if it does not; a rod in line contact lies down instead.
        """
        goes = self.curve.contact_model is Contact.POINT and np.isfinite(self.curve.x0_touch)
        return self.curve.x0_touch if goes else np.inf

    @cached_property
    def kinks(self) -> FloatArray:
        """Displacements at which the kind of contact changes (L)."""
        return self.pieces.first_x0[1:][np.diff(self.pieces.line)]

    @cached_property
    def bounds(self) -> FloatArray:
        """See `States`."""
        return np.unique([self.x0_pull, 0.0, *self.kinks, self.x0_lock, self.x0_end])

    @property
    def whole(self) -> bool:
        """Whether the curve was followed to its lock."""
        return self.curve.status is Status.SOLVED

    @property
    def swings(self) -> bool:
        """Whether the tip can be followed while it is dragged behind the clamp.

        The rod buckles laterally at x0_end, its mounting is ideal (only then is the mirror image of
        a state a state of the rod, too), and states with x0 < 0 were solved.
        """
        curve = self.curve
        dragged = len(curve.retraction) > 0 and curve.mounting.is_ideal
        return dragged and curve.end is End.SWINGS_ASIDE

    def derivative(self, x0: ArrayLike, order: int) -> FloatArray:
        """See `States`; NaN where the states are not known."""
        x0 = np.asarray(x0, dtype=float)
        flat = x0.ravel()
        within = np.clip(flat, self.x0_pull, self.x0_end)
        place = np.searchsorted(self.pieces.first_x0[1:], within, side="right")
        t = self.pieces.places_of(place, within)
        (values,) = self.pieces.values(place, t, LOADS, (order,))
        if order:
            ((growth,),) = self.pieces.values(place, t, ("x0",), (order,))
            values = values / np.where(self.pieces.by_x0[place], 1.0, growth)
        known = (flat >= self.x0_pull) & (flat <= self.x0_end)
        return np.where(known, values, np.nan).T.reshape(*x0.shape, len(LOADS))

    def tip_angle(self, x0: ArrayLike) -> FloatArray:
        """See `States`."""
        x0 = np.asarray(x0, dtype=float)
        within = np.clip(x0.ravel(), self.x0_pull, self.x0_end)
        place = np.searchsorted(self.pieces.first_x0[1:], within, side="right")
        t = self.pieces.places_of(place, within)
        ((angle,),) = self.pieces.values(place, t, TIP_ANGLE, (0,))
        return np.asarray(angle).reshape(x0.shape)

    def state(self, x0: FloatArray) -> StickingState:
        """See `States`."""
        return self.curve.state(x0)

    def shapes(self, x0: FloatArray, offset: FloatArray, s: FloatArray) -> Shape:
        """See `States`."""
        return self.curve.shapes(x0, s)


def responses(rods: Sequence[MountedRod], partly: bool = False) -> list[Response]:
    """Solve the responses of several rods, whose θ, η and mountings may differ.

    Parameters
    ----------
    rods : sequence of MountedRod
        Rods of the same `contact` and the same `section`.
    partly : bool
        Whether to accept curves that the solver did not follow to their end.

    Raises
    ------
    NoResponseError
        If one of the curves was not solved, or a stage is oblique.
    ArgumentError
        If an argument is out of range.
    """
    for rod in rods:
        if angle := rod.mounting.stage_angle:
            raise NoResponseError(
                f"a response at one distance needs stage_angle 0, got {angle!r}: on an oblique "
                "stage the distance changes (see vibrissa.scanning.stage)"
            )
    one, mountings = rods[0], [rod.mounting for rod in rods]
    theta, eta = [rod.theta for rod in rods], [rod.eta for rod in rods]
    curves = solve_curves(theta, eta, one.contact, mountings, one.section, retract=True)
    for curve in curves:
        if not (curve.status is Status.SOLVED or (partly and curve.pieces)):
            raise NoResponseError(f"the sticking curve has status {curve.status}: {curve.message}")
    return [Response(curve=curve) for curve in curves]

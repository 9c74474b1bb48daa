"""The sticking curve: all states of one rod at one height, from α = 0 to the end of its path.

The curve does not depend on friction. μ0 decides where on the curve sticking ends: in the first
state in which the force leaves the friction cone, forward (−tan α = μ0) or back (tan α = μ0).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.errors import ArgumentError
from vibrissa.mechanics.elastica import deformed_shape
from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.mechanics.shape import Shape
from vibrissa.numerics.arrays import FloatArray, IntArray, ObjectArray, StrArray
from vibrissa.outcomes import Contact, End, RodSection, Solver, Status, TipMotion
from vibrissa.sticking.onsets import CurveArray
from vibrissa.sticking.piece import AHEAD, NO_PIECES, Pieces, StickingState
from vibrissa.sticking.shapes import RowStates
from vibrissa.sticking.vibration import check_vibration, state_frequencies

# Displacements that differ by less than this (L) count as equal; shorter pieces are dropped.
SAME_X0 = 1e-12
# Largest number of curves to evaluate together; their samples take some 10 MB.
CURVES_AT_ONCE = 256


@dataclass(frozen=True, eq=False, kw_only=True)
class StickingCurve:
    """Equilibrium path of one rod at one height, from α = 0 to its end; see `vibrissa.solve_curve`.

    Attributes
    ----------
    theta, eta : float
        Taper factor and height of the contact point in the α = 0 state (L).
    mounting : Mounting
    contact_model : Contact
        Whether only the tip may touch the surface (``point``), or the whole rod (``line``).
    method : str
        ``collocation`` or ``shooting``.
    status : Status
        ``solved``, ``failed``, or ``out_of_reach`` if a shape before the lock is inadmissible; the
        curve then has the states before this shape, if any.
    message : str
        What went wrong and what to try; empty if solved.
    end_message : str
        Why the shape is inadmissible or the curve was not followed further; else empty.
    x1_init : float
        Position of the tip in the α = 0 state, with the clamp at x = 0 (L).
    pieces : Pieces
        Smooth pieces of the curve at x0 ≥ 0, where the clamp pushes the tip; x0 increases.
    retraction : Pieces
        Smooth pieces at x0 < 0, where the clamp is pulled back; empty if they were not solved. For
        planar rods and non-ideal mountings they are solved only with the argument `retract` of
        `vibrissa.sticking.api.solve_curves`.
    section : RodSection
    residual : float
        Largest equilibrium residual at points between the solved states. By shooting: largest
        distance of the tip from the contact point (L).
    x0_lock, mu_lock : float
        Displacement (L) at which −tan α is largest on the curve, and −tan α there. If the normal
        force vanishes while the clamp pushes the tip forward (α < 0), `mu_lock` is infinite, and
        `x0_lock` is the end of the curve. Both are NaN if the shape becomes inadmissible while −tan
        α is larger than before. −tan α may have several maxima: a tip with a μ0 above one of them
        goes on sticking, and slips in a later state with −tan α = μ0 if there is one.
    x0_touch : float
        Smallest displacement (L) at which φ1 = 0 or, in tip contact, a part of the rod rises
        through the surface; NaN if there is none before the lock, 0 if the rod lies on the surface
        at α = 0 already.
    end : End
        Why the curve ends. A round rod ``swings_aside`` where the clamp passes under the contact
        point or, in a non-ideal mounting, where `stability_aside` vanishes.
    """

    theta: float
    eta: float
    method: str
    status: Status
    message: str = ""
    x1_init: float = np.nan
    pieces: Pieces = field(default=NO_PIECES, repr=False)
    retraction: Pieces = field(default=NO_PIECES, repr=False)
    section: RodSection = RodSection.ROUND
    residual: float = np.nan
    x0_lock: float = np.nan
    mu_lock: float = np.nan
    x0_touch: float = np.nan
    end: End = End.NOT_FOLLOWED
    end_message: str = ""
    mounting: Mounting = IDEAL
    contact_model: Contact = Contact.POINT

    def contact_point(self, x0: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Position (x, y) of the tip relative to the clamp, at displacements x0 (L).

        In line contact: the point of the surface at the distance 1 − s_c beyond the contact point.
        A straight rod has its tip there; the tip of a curved rod may be off the surface.
        """
        x0, stage_angle = np.asarray(x0, dtype=float), self.mounting.stage_angle
        return self.x1_init - x0 * np.cos(stage_angle), self.eta - x0 * np.sin(stage_angle)

    @property
    def x0_end(self) -> float:
        """Largest displacement (L); NaN if the curve has no states."""
        return float(self.pieces.last_x0[-1]) if self.pieces else np.nan

    def _need_states(self, what: str) -> None:
        if not self.pieces:
            raise ArgumentError(f"a curve with status {self.status} has no {what}: {self.message}")

    @property
    def x0_pull(self) -> float:
        """Smallest displacement (L): negative if the curve has states at x0 < 0, otherwise 0."""
        return float(self.retraction.first_x0[0]) if self.retraction else 0.0

    @cached_property
    def _alone(self) -> CurveArray:
        """The curve as a `CurveArray` of length 1."""
        return curve_array([self])

    def frequencies(self, x0: ArrayLike, count: int = 2, tip: str = TipMotion.STICKS) -> FloatArray:
        """Lowest natural frequencies ω of small vibrations about sticking states.

        Parameters
        ----------
        x0 : float or ndarray
            Displacements between `x0_pull` and `x0_end` (L).
        count : int
            Number of frequencies.
        tip : str
            ``sticks``, or ``slides``: along the surface, under a constant force along the surface.
            `vibrissa.free_frequencies` has those of a rod before contact.

        Returns
        -------
        ndarray, shape x0.shape + (count,)
            Increasing frequencies in rad·√(E·I0/(ρA0·L⁴)); NaN where the state is unstable and does
            not vibrate. `vibrissa.Rod.frequency_unit` converts them to Hz.

        Raises
        ------
        ArgumentError
            If the curve was not solved, a displacement lies outside it, or another argument is not
            allowed.

        Examples
        --------
        >>> from vibrissa import solve_curve
        >>> print(solve_curve(theta=2, eta=0.85).frequencies(0.05).round(4))
        [30.43   70.5823]
        """
        motion = check_vibration(count, tip)
        x0 = np.asarray(x0, dtype=float)
        rows = self.state(x0.ravel())
        line = np.asarray(self.contact(rows.x0)) == Contact.LINE
        found = state_frequencies(self.theta, self.mounting, rows, line, count, motion)
        return found.reshape(*x0.shape, count)

    def contact(self, x0: ArrayLike) -> str | StrArray:
        """Kind of contact, ``point`` or ``line``, at displacements; empty where x0 is NaN.

        Returns
        -------
        str or ndarray of str, shape x0.shape
        """
        x0 = np.asarray(x0, dtype=float)
        rows = x0.ravel() if self.pieces else np.full(x0.size, np.nan)
        kinds = np.array(self._alone.contact(_first(rows), rows), dtype=np.str_)
        found: str | StrArray = kinds.reshape(x0.shape)[()]
        return found

    def state(self, x0: ArrayLike) -> StickingState:
        """Sticking states at displacements between `x0_pull` and `x0_end` (L).

        Raises
        ------
        ArgumentError
            If the curve was not solved or a displacement lies outside it.

        Examples
        --------
        >>> from vibrissa import solve_curve
        >>> state = solve_curve(theta=2, eta=0.85).state(0.05)
        >>> print(f"{state.reaction_fx:.4f} {state.reaction_fy:.4f} {state.reaction_m:.4f}")
        -0.8806 -2.2418 -0.0750
        """
        self._need_states("states")
        x0 = np.asarray(x0, dtype=float)
        if np.any(~(x0 >= self.x0_pull)) or np.any(~(x0 <= self.x0_end + SAME_X0)):
            raise ArgumentError(
                f"x0 must lie on the curve, from {self.x0_pull!r} to {self.x0_end!r}, got "
                f"{x0.tolist()}"
            )
        states = self._alone.states(_first(x0.ravel()), x0.ravel())
        return _shaped(states, x0.shape)

    def mobilised_friction(self, x0: ArrayLike) -> FloatArray:
        """Mobilised friction −tan α at displacements (L); infinite where the tip lifts off."""
        return self.state(x0).mobilised_friction

    def shapes(self, x0: ArrayLike, s: ArrayLike) -> Shape:
        """Deformed shapes at displacements, each an array of shape x0.shape + (points,).

        Parameters
        ----------
        x0 : float or ndarray
            Displacements between `x0_pull` and `x0_end` (L).
        s : ndarray, shape (points,)
            Arc lengths between 0 and 1, increasing (L).

        Raises
        ------
        ArgumentError
            As in `state`.
        """
        x0, s = np.asarray(x0, dtype=float), np.asarray(s, dtype=float)
        rows, state = x0.ravel(), self.state(x0.ravel())
        if self.method == Solver.SHOOTING:
            found = self._integrated(state, s)
        else:
            found = self._alone.shapes(_first(rows), rows, s)
        return Shape(*(values.reshape(*x0.shape, len(s)) for values in found))

    def rod_states(self, x0: FloatArray) -> Iterator[RowStates]:
        """Yield the states of the rod at displacements on the curve, shape (n,), piece by piece."""
        return self._alone.rod_states(_first(x0), x0)

    def _integrated(self, state: StickingState, s: FloatArray) -> Shape:
        """Integrate the rod from its clamp, as shooting does."""
        offset, height = self.contact_point(state.x0)
        rows = zip(state.f, state.alpha, offset, height, state.s_c, strict=True)
        shapes = [deformed_shape(self.theta, *row[:4], s, row[4], self.mounting) for row in rows]
        return Shape(*np.moveaxis(np.reshape(shapes, (len(shapes), 3, len(s))), 1, 0))

    def largest_friction(self, x0: float, way: float = AHEAD) -> float:
        """Largest −tan α (`way` = `AHEAD`) or tan α (`BACK`) from α = 0 to a displacement (L).

        It is the least μ0 with which a tip still sticks there; 0 if no friction was needed.
        """
        peaks = self.pieces.peaks(way)
        states = self.pieces.at(*peaks)
        before = way * states.mobilised_friction[states.x0 <= x0]
        return float(np.append(before, way * self.mobilised_friction(x0)).max(initial=0.0))

    def onset(self, mu0: ArrayLike) -> FloatArray:
        """Exact onset of slip (L): the first displacement at which −tan α = μ0.

        NaN where the tip locks: μ0 > μ_lock, or the tip slips back before (`motion_end`). NaN also
        where the curve ends before the onset.

        Raises
        ------
        ArgumentError
            If the curve was not solved or a coefficient is not positive.

        Examples
        --------
        >>> from vibrissa import solve_curve
        >>> print(solve_curve(theta=2, eta=0.85).onset([0.2, 0.4, 0.5]).round(6))
        [0.013232 0.052838      nan]
        """
        mu0 = np.asarray(mu0, dtype=float)
        if np.any(~(mu0 > 0.0)):
            raise ArgumentError(f"mu0 must be positive, got {mu0!r}")
        self._need_states("onset")
        # [()] makes a number of an array without axes.
        return self._alone.onset(_first(mu0.ravel()), mu0.ravel()).reshape(mu0.shape)[()]

    def motion_end(self, mu0: ArrayLike) -> tuple[End | ObjectArray, StickingState]:
        """How sticking of a locked tip ends, and in which state.

        Returns
        -------
        ends : End, or ndarray of End with shape mu0.shape
            ``slips_back`` if tan α reaches +μ0; else the `end` of the curve.
        states : StickingState
            States in which sticking ends, with columns of the shape of `mu0`; NaN if the curve was
            not followed to its end.

        Raises
        ------
        ArgumentError
            If the curve was not solved or the tip slips forward with one of the coefficients.
        """
        self._need_states("end")
        if self.status is not Status.SOLVED:
            raise ArgumentError(f"the lock of this curve is not known: {self.message}")
        mu0 = np.asarray(mu0, dtype=float)
        if np.any(np.isfinite(self.onset(mu0))):
            raise ArgumentError(f"mu0 must exceed mu_lock = {self.mu_lock:.6g}, got {mu0!r}")
        ends, states = self._alone.motion_end(_first(mu0.ravel()), mu0.ravel())
        found: End | ObjectArray = np.array(ends, dtype=object).reshape(mu0.shape)[()]
        return found, _shaped(states, mu0.shape)

    def trailing_end(self, mu0: ArrayLike) -> StickingState:
        """States in which the tip slips while it trails behind the clamp, after lateral buckling.

        Each μ0 must exceed μ_lock. x0 counts from the α = 0 state before the buckling. NaN if the
        rod does not buckle, or if this curve has no state at x0 < 0 in which the tip slips. The
        columns have the shape of `mu0`.
        """
        mu0 = np.asarray(mu0, dtype=float)
        return _shaped(self._alone.trailing_end(_first(mu0.ravel()), mu0.ravel()), mu0.shape)


def curve_array(curves: Sequence[StickingCurve]) -> CurveArray:
    """Join at least one curve, to evaluate all of them together."""
    pieces = [(curve.retraction, curve.pieces) for curve in curves]
    return CurveArray(
        pieces=Pieces.concatenate([part for both in pieces for part in both]),
        retracted=np.array([len(curve.retraction) for curve in curves], dtype=np.int64),
        pushing=np.array([len(curve.pieces) for curve in curves], dtype=np.int64),
        x0_lock=np.array([curve.x0_lock for curve in curves]),
        mu_lock=np.array([curve.mu_lock for curve in curves]),
        status=np.array([curve.status for curve in curves], dtype=object),
        end=np.array([curve.end for curve in curves], dtype=object),
    )


def _first(rows: FloatArray) -> IntArray:
    """Return the index of the only curve, 0, for each row."""
    return np.zeros(len(rows), dtype=np.int64)


def _shaped(states: StickingState, shape: tuple[int, ...]) -> StickingState:
    """Give the columns of states another shape; [()] makes a number of an array without axes."""
    return states.each(lambda values: values.reshape(shape)[()])


def failed_curve(
    theta: float,
    eta: float,
    message: str,
    status: Status = Status.FAILED,
    method: str = Solver.COLLOCATION,
) -> StickingCurve:
    """Curve without states, ``failed`` or ``out_of_reach``, with the reason in its message."""
    return StickingCurve(
        theta=theta, eta=eta, method=method, status=status, message=message, end_message=message
    )

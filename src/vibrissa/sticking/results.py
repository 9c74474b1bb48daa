"""Results for notebooks, which print as tables: an equilibrium, and the end of sticking."""

from dataclasses import dataclass, field

import numpy as np

from vibrissa.errors import ArgumentError
from vibrissa.mechanics.admissibility import CLEARANCE_TOLERANCE, clearances
from vibrissa.mechanics.equations import shape
from vibrissa.mechanics.shape import Shape
from vibrissa.mechanics.states import ContactState, RodStates
from vibrissa.mechanics.vibration import natural_frequencies
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact, Status, TipMotion
from vibrissa.sticking.piece import StickingState
from vibrissa.sticking.vibration import check_vibration

# Warning about rods in point contact that do what no real rod does.
PENETRATES = "the rod passes through the surface: contact='line' lets it lie on it"


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class EquilibriumState(ContactState):
    """One equilibrium of the rod with its tip held at a point of the surface.

    Attributes
    ----------
    status : Status
        ``solved``, ``out_of_reach`` or ``failed``; without a solution all numbers are NaN.
    message : str
        What went wrong and what to try; empty if solved.
    contact : str
        ``point`` if the tip alone touches, ``line`` if the rod lies along the surface; empty
        without a solution.
    theta, x1, eta : float
        Taper factor and position of the tip relative to the clamp (L).
    residual : float
        Largest residual of the equations.
    """

    status: Status
    message: str
    contact: str
    theta: float
    x1: float
    eta: float
    residual: float
    _solution: RodStates | None = field(default=None, repr=False)

    @property
    def marks(self) -> list[str]:
        """What makes the state no state of a real rod: it penetrates, or it is unstable."""
        return _marks(self.penetrates, self)

    def __repr__(self) -> str:
        """Return status, numbers and marks on one line each."""
        names = ("theta", "eta", "x1", *ContactState.names(), "residual")
        lines = [f"{name:<16} {getattr(self, name):.6g}" for name in names]
        status = f"{'status':<16} {self.status.value} {self.contact} {self.message}".rstrip()
        return "\n".join([status, *lines, *(f"{'warning':<16} {mark}" for mark in self.marks)])

    @property
    def penetrates(self) -> bool:
        """Whether the shape passes through the surface in point contact: φ1 < 0, or an arch."""
        if self._solution is None or self.contact != Contact.POINT:
            return False
        clearance = clearances(self._solution, np.array([self.eta]), ("surface",))
        return bool(self.phi1 < 0.0 or clearance.surface[0] < -CLEARANCE_TOLERANCE)

    def frequencies(self, count: int = 2, tip: str = TipMotion.STICKS) -> FloatArray:
        """Lowest natural frequencies ω of small vibrations about the state.

        Parameters
        ----------
        count : int
            Number of frequencies.
        tip : str
            ``sticks`` or ``slides``, as in `StickingCurve.frequencies`.

        Returns
        -------
        ndarray, shape (count,)
            Increasing frequencies in rad·√(E·I0/(ρA0·L⁴)); NaN if the state is unstable.

        Raises
        ------
        ArgumentError
            If the state was not solved, or an argument is not allowed.
        """
        motion = check_vibration(count, tip)
        if self._solution is None:
            raise ArgumentError(
                f"a state with status {self.status} has no frequencies: {self.message}"
            )
        return np.asarray(natural_frequencies(self._solution, count, motion)[0])

    def shape(self, s: FloatArray | None = None) -> Shape:
        """Deformed shape with the clamp at the origin.

        Parameters
        ----------
        s : ndarray, shape (points,), optional
            Arc lengths from 0 to 1 (L); 101 equally spaced ones by default.

        Returns
        -------
        Shape

        Raises
        ------
        ArgumentError
            If the state was not solved, or an arc length lies outside the rod.
        """
        if self._solution is None:
            raise ArgumentError(f"a state with status {self.status} has no shape: {self.message}")
        s = np.linspace(0.0, 1.0, 101) if s is None else np.asarray(s, dtype=float)
        if not ((s >= 0.0) & (s <= 1.0)).all():
            raise ArgumentError(f"arc lengths must lie between 0 and 1 (L), got {s.tolist()}")
        return Shape(*(values[0] for values in shape(self._solution, s)))


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Onset:
    """End of one period of sticking: the onset of slip, or the lock; prints as a short table.

    Attributes
    ----------
    status : Status
        ``slip`` (forward), ``lock`` (the tip slips back first, or sticks up to the end of the
        curve), ``out_of_reach`` or ``failed``.
    message : str
        Explanation of the status, and what to try.
    x0_slip : float
        Exact onset of slip (L), the first state on the curve with −tan α = μ0; NaN unless the tip
        slips forward.
    n_steps : int or None
        Number of steps from α = 0 to the last step at which the tip sticks; None without dx0 or
        without an onset.
    x0_max : float
        Displacement after `n_steps` steps, the paper's x0,max (L); NaN where `n_steps` is None.
    mu_lock : float
        Largest −tan α on the curve, infinite if the normal force vanishes while the clamp pushes
        the tip forward. A tip with a larger μ0 never slips forward.
    slip : StickingState
        State at the exact onset of slip.
    end : str
        How sticking of a locked tip ends (`vibrissa.outcomes.End`), with ``slips_back`` also before
        −tan α is largest; empty unless the tip locks.
    ended : StickingState
        State in which sticking of a locked tip ends; NaN unless the tip locks.
    trail : StickingState
        Last sticking state after lateral buckling, when the rod trails behind the clamp; NaN if
        the rod does not buckle. Its x0 counts from the α = 0 state in which the period began.
    penetrates : bool
        Whether the rod passes through the surface before the onset or the lock, which no real rod
        does.
    residual : float
        Largest equilibrium residual of the sticking curve.
    """

    status: Status
    message: str
    x0_slip: float
    n_steps: int | None
    x0_max: float
    mu_lock: float
    slip: StickingState
    end: str
    ended: StickingState
    trail: StickingState
    penetrates: bool
    residual: float

    @property
    def marks(self) -> list[str]:
        """What makes the result no result of a real rod: it penetrates, or it is unstable."""
        return _marks(self.penetrates, self.slip)

    def __repr__(self) -> str:
        """Return a line for each known quantity: name, value, unit and meaning."""
        slip = self.slip
        rows = [
            ("x0_slip", self.x0_slip, "L", "exact onset of slip"),
            ("x0_max", self.x0_max, "L", f"last sticking step, number {self.n_steps}"),
            ("mu_lock", self.mu_lock, "1", "largest friction at which the tip slips"),
            ("f", slip.f, "E·I0/L²", "contact force at the onset"),
            ("alpha", slip.alpha, "rad", "inclination of the contact force"),
            ("phi1", slip.phi1, "rad", "slope at the contact point"),
            ("reaction_fx", slip.reaction_fx, "E·I0/L²", "load on the clamp"),
            ("reaction_fy", slip.reaction_fy, "E·I0/L²", "load on the clamp"),
            ("reaction_m", slip.reaction_m, "E·I0/L", "load on the clamp"),
            ("x0_end", self.ended.x0, "L", f"end of sticking: {self.end}"),
            ("x0_trail", self.trail.x0, "L", "last sticking state of the trailing rod"),
            ("residual", self.residual, "", "largest residual of the equilibrium equations"),
        ]
        known = [row for row in rows if not np.isnan(row[1])]
        lines = (f"{n:<12} {value:<11.6g} {unit:<8} {text}" for n, value, unit, text in known)
        marks = (f"{'warning':<12} {mark}" for mark in self.marks)
        return "\n".join([f"{'status':<12} {self.status.value}: {self.message}", *lines, *marks])


def _marks(penetrates: bool, state: ContactState) -> list[str]:
    """Describe why a rod does not take this state although it is an equilibrium."""
    marks = []
    if penetrates:
        marks.append(PENETRATES)
    if state.stability < 0.0:
        marks.append("the state is unstable in its plane: the rod snaps before")
    if state.stability_aside < 0.0:
        marks.append("the state is unstable out of its plane: a round rod buckles before")
    return marks

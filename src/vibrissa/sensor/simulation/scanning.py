"""A scan: the clamp moves in steps over a surface, and the tip sticks and slips.

At the first step at which |tan α| > μ0 the tip slips while the clamp rests. A self-locking tip
sticks until the rod, if it is round, buckles laterally. After that the clamp drags the tip: the
states of the rod are mirror images of states in which the tip is ahead of the clamp.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from enum import StrEnum

import numpy as np

from vibrissa.decimals import exact
from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray, IntArray, StrArray
from vibrissa.numerics.batch import Batch
from vibrissa.numerics.steps import step_position
from vibrissa.quantities.series import Column, Tabular
from vibrissa.quantities.units import Kind, Quantity, Units, chosen
from vibrissa.sensor.response.branch import Response
from vibrissa.sensor.response.heights import Stage
from vibrissa.sensor.simulation.tip import BACKWARD, END, SlipLaw, Tip
from vibrissa.sensor.surfaces import Surface
from vibrissa.sensor.transducer import Transducer, transducer_of
from vibrissa.sensor.whisker import Whisker
from vibrissa.wording import counted

# Largest number of steps; more would fill the memory.
MOST_STEPS = 10**8
LOCKS = "the tip locks at x = {x}, where mu0 = {mu0:.6g} and mu_lock = {mu_lock:.6g}; "
SWINGS = (
    LOCKS + "with the clamp at {clamp} the rod buckles laterally, and its tip is dragged behind"
)
STAYS = LOCKS + (
    "pushed further, it sticks until the clamp is at {clamp}; the motion after that is not computed"
)
LOST = (
    "the slip from x = {x}, with the clamp at {clamp}, releases so much energy that the tip lifts "
    "off the surface, or the rod is bent beyond its computed states"
)
# Part of a step by which a turn may miss a whole number of steps, by rounding in units of L.
ROUNDED_AWAY = 1e-6


class TipPhase(StrEnum):
    """Phase of the tip at a step.

    Attributes
    ----------
    STICK
        The tip has not slipped since the previous step.
    LOCK
        The tip sticks at x0 > x0_lock, the displacement at which −tan α is largest: pushed
        further, it does not slip forward.
    SLIP
        The tip has just slipped and is at rest.
    SWING
        The rod has just buckled laterally. Its tip sticks, on the other side of the clamp.
    """

    STICK = "stick"
    LOCK = "lock"
    SLIP = "slip"
    SWING = "swing"


class TipSide(StrEnum):
    """Side of the clamp on which the tip is: ahead of it, as at the start, or behind it."""

    AHEAD = "ahead"
    BEHIND = "behind"


class Outcome(StrEnum):
    """How a scan ended.

    Attributes
    ----------
    COMPLETE
        The clamp reached the end of the path.
    LOCK
        The tip locked and was pushed until sticking ended; the motion after that is not computed.
    LOST
        A slip passed α = 0 and did not end within the computed states. Either the clamp had pushed
        the tip, and the tip lifted off the surface; or the clamp had pulled the tip, and the tip
        came to the last computed state in which the clamp pushes it.
    """

    COMPLETE = "complete"
    LOCK = "lock"
    LOST = "lost"


@dataclass(frozen=True, eq=False, kw_only=True)
class SurfaceScan(Batch):
    """States of a scan, one row for each step of the clamp.

    Attributes
    ----------
    outcome : Outcome
    message : str
        Says where the rod first buckled laterally, and where and why the scan ended early.
    clamp : ndarray, shape (n,)
        Position of the clamp along its stage (L).
    contact : ndarray, shape (n,)
        Position of the tip, which is the contact point in point contact (L).
    x0 : ndarray, shape (n,)
        Displacement of the clamp along the surface (L), from the α = 0 state with the same
        `contact`, the same `side`, and the same height of the surface above the clamp.
    reactions : ndarray, shape (n, 3)
        Clamp reactions fx, fy (E·I0/L²) and m (E·I0/L).
    mu0 : ndarray, shape (n,)
        Coefficient of static friction at the contact point.
    period : ndarray of int, shape (n,)
        Number of the period of sticking, from 1. The step of a slip is the first of a new period.
    phase, side : ndarray of str, shape (n,)
        `TipPhase` and `TipSide` at each step.
    """

    outcome: Outcome
    message: str
    clamp: FloatArray
    contact: FloatArray
    x0: FloatArray
    reactions: FloatArray
    mu0: FloatArray
    period: IntArray
    phase: StrArray
    side: StrArray


def path(step: Decimal | float | str, turns: Sequence[Decimal | float | str]) -> FloatArray:
    """Compute positions of a stage that moves in equal steps from 0 through all turning points.

    Parameters
    ----------
    step : Decimal or float or str
        Step of the stage (L).
    turns : sequence of Decimal or float or str
        Positions at which the stage turns; at the last one it stops (L). They are rounded to
        whole steps, towards 0.

    Returns
    -------
    ndarray
        Positions (L), the start included.

    Raises
    ------
    ArgumentError
        If the step is not positive or too small, or a part of the path is shorter than a step.
    """
    size = exact(step)
    if not size > 0:
        raise ArgumentError(f"step must be positive, got {step}")
    ways = np.diff([0, *(_steps_to(turn, size) for turn in turns)])
    if (total := abs(ways).sum()) > MOST_STEPS:
        raise ArgumentError(
            f"the step is too small: the path has {total:.3g} steps, more than {MOST_STEPS:,}"
        )
    if not ways.all():
        raise ArgumentError("each part of the path must be at least one step long")
    way = np.repeat(np.sign(ways), np.abs(ways))
    return step_position(np.append(0, np.cumsum(way)), size)


def _steps_to(turn: Decimal | float | str, size: Decimal) -> int:
    """Count the whole steps up to a turn, robust to the rounding of converted units."""
    quotient = exact(turn) / size
    nearest = round(quotient)
    return nearest if abs(quotient - nearest) < ROUNDED_AWAY else int(quotient)


def simulate(
    rod: Response | Stage,
    surface: Surface,
    positions: FloatArray,
    law: SlipLaw | str = SlipLaw.FREE,
    kinetic_ratio: float = 0.8,
) -> SurfaceScan:
    """Simulate a scan: find the state of the rod at each step of the clamp over a surface.

    Parameters
    ----------
    rod : Response or Stage
        The rod on its stage; a `Response` is on a level stage.
    surface : Surface
    positions : ndarray
        Clamp positions along the stage (L), as from `path`; the scan begins in the α = 0 state.
    law : SlipLaw or str
        Where a slip ends.
    kinetic_ratio : float
        μk/μ0, for the laws ``kinetic`` and ``energy``.

    Returns
    -------
    SurfaceScan
        A row for each step, up to the end of the path or of the computed motion.

    Raises
    ------
    ArgumentError
        If an argument is out of range, if the tip leaves the known part of the surface, or if the
        path or the law may need states with x0 < 0 (the clamp pulled back) that were not solved.
    """
    positions, law = np.asarray(positions, dtype=float), chosen(SlipLaw, law, "law")
    if not 0.0 < kinetic_ratio <= 1.0:
        raise ArgumentError(f"kinetic_ratio must be above 0 and at most 1, got {kinetic_ratio!r}")
    stage = Stage(rod=rod, eta=rod.curve.eta) if isinstance(rod, Response) else rod
    at, told = float(positions[0]), surface.told
    start = stage.at(at)
    retracts = law is SlipLaw.ENERGY or stage.angle < 0.0 or (np.diff(positions) < 0.0).any()
    if retracts and start.x0_pull == 0.0:
        raise ArgumentError(
            "states in which the clamp is pulled back (x0 < 0) could not be solved. The law "
            "'energy' needs them, and so does a path backward or away from the surface: choose "
            "another path or law"
        )
    outcome, message = Outcome.COMPLETE, ""
    contact = start.contact(float(stage.along(at)), 0.0, 1)
    tip = Tip(stage=stage, contact=contact, mu0=float(surface(contact)))
    tips, swing = [tip], ""
    while True:
        step, until = tip.end(positions, at)
        if step == len(positions):
            break
        margin, pushed = tip.exit(until)
        if margin == END and stage.rod.swings:
            swing = swing or _message(SWINGS, tip, until, float(positions[step]), told)
            # After lateral buckling the tip is at its mirror image about the clamp.
            at, contact = until, 2.0 * float(stage.along(until)) - tip.contact
            tip = replace(tip, contact=contact, side=-tip.side, begin=step, slipped=False)
        elif margin == END or (pushed and margin == BACKWARD):
            outcome = Outcome.LOCK
            message = _message(STAYS, tip, until, float(positions[step - 1]), told)
            break
        else:
            at = float(positions[step])
            contact = tip.slid(at, surface, law, kinetic_ratio)
            if np.isnan(contact):
                outcome, message = Outcome.LOST, _message(LOST, tip, until, at, told)
                break
            mu0 = float(surface(contact))
            tip = replace(tip, contact=contact, mu0=mu0, begin=step, slipped=True)
        tips.append(tip)
    return _assembled(tips, positions[:step], outcome, "; ".join(filter(None, (swing, message))))


def _message(text: str, tip: Tip, until: float, clamp: float, told: Callable[[float], str]) -> str:
    """Complete a message for a tip that sticks up to the clamp position `until`."""
    mu_lock = tip.stage.at(until).mu_lock
    return text.format(x=told(tip.contact), mu0=tip.mu0, mu_lock=mu_lock, clamp=told(clamp))


def _assembled(
    tips: Sequence[Tip], clamp: FloatArray, outcome: Outcome, message: str
) -> SurfaceScan:
    """Assemble a scan, with one row for each step, from the places at which the tip stuck."""
    begins = np.array([tip.begin for tip in tips])
    slipped = np.array([tip.slipped for tip in tips])
    counts = np.diff(begins, append=len(clamp))
    contact, mu0, side = (
        np.repeat([getattr(tip, name) for tip in tips], counts)
        for name in ("contact", "mu0", "side")
    )
    states, x0 = tips[0].stage.states(clamp, contact, side)
    phase = np.where(x0 > states.x0_lock, TipPhase.LOCK, TipPhase.STICK)
    # If the rod buckles laterally and slips in the same step, the tip in between has no row.
    later = (begins > 0) & (counts > 0)
    phase[begins[later]] = np.where(slipped[later], TipPhase.SLIP, TipPhase.SWING)
    return SurfaceScan(
        outcome=outcome,
        message=message,
        clamp=clamp,
        contact=contact,
        x0=side * x0 + 0.0,  # no −0
        reactions=states(states.clip(x0)) * np.stack([side, np.ones(len(side)), side], axis=1),
        mu0=mu0,
        period=np.repeat(np.cumsum(slipped), counts),
        phase=phase,
        side=np.where(side == 1, TipSide.AHEAD, TipSide.BEHIND),
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class Signals(Tabular):
    """Signals of a scan at the clamp: `scan` returns them exact, `measured` with noise.

    Attributes
    ----------
    truth : SurfaceScan
        States of the scan, nondimensional and without noise.
    readings : ndarray, shape (n, 3)
        Columns force_x, force_y and moment_z in the units that `columns` gives: exact clamp
        reactions, or readings of a transducer.
    units : Units
    """

    truth: SurfaceScan
    readings: FloatArray
    units: Units

    def measured(self, transducer: Transducer | str, seed: int = 0) -> "Signals":
        """Return a copy with readings of a transducer; `seed` fixes their noise."""
        sensor = transducer_of(transducer, self.units)
        generator = np.random.default_rng([seed, 1])
        return replace(self, readings=sensor.measured(self.readings, generator))

    def __repr__(self) -> str:
        """Numbers of steps and periods, and how the scan ended."""
        truth = self.truth
        said = f"{counted(len(truth), 'step')}, {counted(int(truth.period[-1]), 'period')}"
        return "\n".join(filter(None, (f"{said}, {truth.outcome}", truth.message)))

    def columns(self) -> dict[str, Column]:
        """Columns by name, with units; they have one row for each step of the clamp."""
        truth, unit = self.truth, self.units.unit(Kind.LENGTH)
        length, force, moment = (
            self.units.name(kind) for kind in (Kind.LENGTH, Kind.FORCE, Kind.MOMENT)
        )
        force_x, force_y, moment_z = self.readings.T
        return {
            "footpoint": Column(truth.clamp * unit, length, "position of the clamp"),
            "force_x": Column(force_x, force, "clamp force along the surface"),
            "force_y": Column(force_y, force, "clamp force normal to the surface"),
            "moment_z": Column(moment_z, moment, "clamp moment"),
            "contact": Column(truth.contact * unit, length, "position of the tip"),
            "x0": Column(truth.x0 * unit, length, "clamp displacement from the alpha = 0 state"),
            "mu0": Column(truth.mu0, "1", "static friction under the tip"),
            "period": Column(truth.period, "1", "number of the period of sticking"),
            "phase": Column(truth.phase, "", ", ".join(TipPhase)),
            "side": Column(truth.side, "", "where the tip is: " + " or ".join(TipSide)),
        }


def scan(
    whisker: Whisker,
    surface: Surface,
    *,
    step: Quantity,
    to: Quantity | Sequence[Quantity],
    law: SlipLaw | str = SlipLaw.FREE,
    kinetic_ratio: float = 0.8,
) -> Signals:
    """Move the clamp over a surface and record the signals.

    Parameters
    ----------
    whisker : Whisker
    surface : Surface
    step : str or number
        Step of the stage.
    to : str or number, or sequence of these
        Positions at which the stage turns; at the last one it stops.
    law : SlipLaw
        Where a slip ends.
    kinetic_ratio : float
        μk/μ0, for the laws ``kinetic`` and ``energy``.

    Returns
    -------
    Signals
        Exact signals; `Signals.measured` adds the noise of a transducer.

    Raises
    ------
    ArgumentError
        If an argument is out of range, or the tip leaves the known part of the surface.
    """
    units = whisker.units
    positions = path(
        units.read_positive(step, Kind.LENGTH, "step"),
        [units.read(turn, Kind.LENGTH, "to") for turn in np.array(to, dtype=object).ravel()],
    )
    truth = simulate(
        whisker.stage(positions), replace(surface, units=units), positions, law, kinetic_ratio
    )
    return Signals(truth=truth, readings=truth.reactions * units.channels, units=units)

"""Numbers that others published, beside ours.

Each file of validation/sources holds the numbers of one source, as they are printed there. Exit
status 1 if one of them differs from ours by more than its rounding and no reason is known, or if
one agrees that is said to differ.
"""

import csv
import enum
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from inspect import cleandoc
from pathlib import Path

import numpy as np
from scipy.optimize import brentq, root

from validation.records import write_record
from vibrissa import EquilibriumState, Rod, StickingState, solve_curve, solve_state
from vibrissa.mechanics.buckling import buckling_load
from vibrissa.mechanics.equations import ClosingCondition, ends
from vibrissa.mechanics.mounting import IDEAL, rod_columns
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.states import RodStates
from vibrissa.outcomes import Contact
from vibrissa.sticking.solving.beginning import begin

SOURCES = Path(__file__).parent / "sources"

# A heavily loaded rod is approached from the same rod under a load smaller by this (E·I0/L²).
LOAD_STEP = Decimal("0.5")
# Heights between which a cylinder under α = 0 is sought; the published tips turn by 20° to 120°.
NODES = 64
HEIGHTS = (0.1, 0.9999)
# Loads (E·I0/L²) and shortenings (L) from which a limit at zero is extrapolated.
SMALL_LOAD, SMALL_SHORTENING = Decimal("0.04"), 0.001


class Rounding(enum.Enum):
    """How a printed number came out of an exact one.

    The value says how far the exact magnitude may lie below and above the printed one, in units of
    the last printed digit.
    """

    EXACT = (0.0, 0.0)
    NEAREST = (0.5, 0.5)
    # To one digit more first, and then again.
    TWICE = (0.55, 0.55)
    # Some numbers of a table are rounded, others have their further digits cut off.
    NEAREST_OR_CUT = (0.5, 1.0)


@dataclass(frozen=True, kw_only=True)
class Printed:
    """A number as it is printed.

    Attributes
    ----------
    text : str
    digit : Decimal
        Size of one unit of the last digit.
    rounding : Rounding
    """

    text: str
    digit: Decimal
    rounding: Rounding

    @property
    def value(self) -> Decimal:
        """The number itself."""
        return Decimal(self.text)

    def bounds(self) -> tuple[float, float]:
        """Give the least and the largest exact number that is printed so."""
        below, above = (share * float(self.digit) for share in self.rounding.value)
        value = float(self.value)
        return (value - below, value + above) if value >= 0.0 else (value - above, value + below)


@dataclass(frozen=True, kw_only=True)
class Number:
    """A published number.

    Attributes
    ----------
    quantity : str
        Name of the function that computes ours.
    argument, value : Printed
    place : str
        Where in the source it stands.
    known_difference : str
        Why it differs from ours; empty for nearly all.
    """

    quantity: str
    argument: Printed
    value: Printed
    place: str
    known_difference: str


@dataclass(frozen=True, kw_only=True)
class Source:
    """What one source published.

    Attributes
    ----------
    title : str
    notes : str
        Citation, and how the numbers were read.
    numbers : tuple of Number
    """

    title: str
    notes: str
    numbers: tuple[Number, ...]


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """A published number beside ours.

    Attributes
    ----------
    number : Number
    ours : float
    allowed : tuple of float
        Least and largest difference, ours less published, that the source's rounding explains.
    """

    number: Number
    ours: float
    allowed: tuple[float, float]

    @property
    def difference(self) -> float:
        """Ours less published."""
        return self.ours - float(self.number.value.value)

    @property
    def agrees(self) -> bool:
        """Whether the source's rounding explains the difference."""
        least, largest = self.allowed
        return least <= self.difference <= largest

    @property
    def expected(self) -> bool:
        """Whether it agrees, or differs for a known reason."""
        return self.agrees != bool(self.number.known_difference)


# --- What corresponds to the published quantities. Their descriptions appear on the page. ---


def conical_column(ratio: Decimal) -> float:
    """Critical load P·L²/(E·I_base) over I_tip/I_base.

    The force of our α = 0 states tends to it as η → 1 (`buckling_load`). I goes with the fourth
    power of the diameter, so that θ = (I_tip/I_base)^(−1/4).
    """
    return float(buckling_load(np.array([float(ratio) ** -0.25]))[0])


def hinged_bar(half_length: Decimal) -> float:
    """Critical load of a bar hinged at both ends (lb), over half its length (in).

    E = 3·10⁷ psi, 0.5 in × 0.5 in. By symmetry each half is a column clamped at one end and free at
    the other: our critical load at θ = 1, for L = half the length.
    """
    stiffness = 3e7 * 0.5**4 / 12.0
    return conical_column(Decimal(1)) * stiffness / float(half_length) ** 2


def post_buckled_load(tip_angle: Decimal) -> float:
    """Load over critical load F/F_cr, over the angle by which the tip has turned (degrees).

    Our α = 0 states at θ = 1: the force is vertical and free to move with the tip. The clamp holds
    φ = 90°, so that the tip has turned by 90° − φ1. F_cr = π²/4.
    """
    return _load_ratio(_turned_by(tip_angle))


def post_buckled_deflection(tip_angle: Decimal) -> float:
    """Sideways displacement of the tip, over its angle (degrees), for L = 100 in.

    Our x1, in the same state.
    """
    return 100.0 * _turned_by(tip_angle).x1


def post_buckled_shortening(tip_angle: Decimal) -> float:
    """Displacement of the tip along the bar, over its angle (degrees), for L = 100 in.

    Our 1 − η, in the same state.
    """
    return 100.0 * (1.0 - _turned_by(tip_angle).eta)


def post_buckled_deflection_under(load_ratio: Decimal) -> float:
    """Sideways displacement of the tip over F/F_cr, for L = 0.5 m.

    Our x1 in the α = 0 state at θ = 1 whose force is F.
    """
    return 0.5 * _loaded_by(load_ratio).x1


def post_buckled_shortening_under(load_ratio: Decimal) -> float:
    """Displacement of the tip along the bar over F/F_cr, for L = 0.5 m.

    Our 1 − η, in the same state.
    """
    return 0.5 * (1.0 - _loaded_by(load_ratio).eta)


def cantilever_deflection(load: Decimal) -> float:
    """Displacement of the tip along the force, w/L, over P·L²/(E·I).

    A dead force at right angles to the unloaded rod is our force at α = 90°, which points to +x.
    The state is the one with fx = P and fy = 0; w is its x1.
    """
    return dead_load(1.0, load, 90.0).x1


def cantilever_shortening(load: Decimal) -> float:
    """Displacement of the tip along the unloaded rod, u/L, over P·L²/(E·I).

    Our 1 − η, in the same state.
    """
    return 1.0 - dead_load(1.0, load, 90.0).eta


def cantilever_rotation(load: Decimal) -> float:
    """Angle by which the tip has turned (rad), over P·L²/(E·I).

    Our π/2 − φ1, in the same state.
    """
    return _turn(dead_load(1.0, load, 90.0))


def pulled_frame_height(load: Decimal) -> float:
    """Displacement v/L of each loaded corner along its force, over P·L²/(E·I).

    Four rods of length L form a square that stands on a corner. The upper and the lower corner are
    hinges and are pulled apart by 2P; the two others are rigid. By symmetry a rigid corner moves
    without turning, so that each rod is our clamped rod, with the force P at its tip, at 45° to the
    unloaded rod and away from the clamp: α = 135°. Across and along the unloaded rod the tip moves
    by x1 = (v + h)/√2 and η − 1 = (v − h)/√2, where h is the way of the rigid corner inwards.
    """
    tip = dead_load(1.0, load, 135.0)
    return (tip.x1 - (1.0 - tip.eta)) / np.sqrt(2.0)


def pulled_frame_width(load: Decimal) -> float:
    """Displacement h/L of each rigid corner inwards, over P·L²/(E·I).

    From the same two equations.
    """
    tip = dead_load(1.0, load, 135.0)
    return (tip.x1 + (1.0 - tip.eta)) / np.sqrt(2.0)


def pulled_frame_slope(load: Decimal) -> float:
    """Slope of the rods at the hinges against the horizontal (rad), over P·L²/(E·I).

    π/4 without load; the force turns the tip upright, by our π/2 − φ1.
    """
    return np.pi / 4.0 + _turn(dead_load(1.0, load, 135.0))


def pressed_frame_height(load: Decimal) -> float:
    """Displacement v/L of each loaded corner along its force, over P·L²/(E·I).

    The same frame, pressed together: the force at the tip is at 45° to the unloaded rod and towards
    the clamp, α = 45°. Now x1 = (v + h)/√2 and 1 − η = (v − h)/√2, with h outwards.
    """
    tip = dead_load(1.0, load, 45.0)
    return (tip.x1 + (1.0 - tip.eta)) / np.sqrt(2.0)


def pressed_frame_width(load: Decimal) -> float:
    """Displacement h/L of each rigid corner outwards, over P·L²/(E·I).

    From the same two equations.
    """
    tip = dead_load(1.0, load, 45.0)
    return (tip.x1 - (1.0 - tip.eta)) / np.sqrt(2.0)


def pressed_frame_slope(load: Decimal) -> float:
    """Slope of the rods at the hinges against the horizontal (rad), over P·L²/(E·I).

    π/4 without load; the force turns the tip down, by our π/2 − φ1.
    """
    return np.pi / 4.0 - _turn(dead_load(1.0, load, 45.0))


def console_deflection(force: Decimal) -> float:
    """Displacement of the tip along the force (m), over the force (tf).

    L = 10 m, E·I = 100 tf·m²: the unit of force is 1 tf. Our x1 at α = 90°.
    """
    return 10.0 * cantilever_deflection(force)


def console_shortening(force: Decimal) -> float:
    """Displacement of the tip along the unloaded rod (m), over the force (tf).

    Our 1 − η, in the same state.
    """
    return 10.0 * cantilever_shortening(force)


def console_moment(force: Decimal) -> float:
    """Moment at the clamp (tf·m), over the force (tf).

    The unit of moment is 10 tf·m. The size of our m(0), in the same state.
    """
    return 10.0 * abs(dead_load(1.0, force, 90.0).reaction_m)


def console_stability(length: Decimal) -> float:
    """Critical load over 1 tf, over the length (m).

    E·I = 100 tf·m²; clamped and free. Our critical load at θ = 1.
    """
    return conical_column(Decimal(1)) * 100.0 / float(length) ** 2


def small_deflection(force: Decimal) -> float:
    """Displacement of the tip (m), over the force (N).

    E = 2·10¹¹ Pa, L = 1 m, radius from 0.1 m to 0.05 m: θ = 2. Linear theory is our limit of small
    forces at α = 90°; x1/f is extrapolated to f = 0.
    """
    return _per_small_load(lambda state: state.x1) * float(force) / _tapered().force_unit


def small_rotation(force: Decimal) -> float:
    """Angle by which the tip has turned (rad), over the force (N).

    (π/2 − φ1)/f, extrapolated likewise.
    """
    return _per_small_load(_turn) * float(force) / _tapered().force_unit


def small_stress(force: Decimal) -> float:
    """Largest stress at the clamp (Pa), over the force (N).

    E times the strain at the surface there, |φ'(0)|·d0/2; |φ'(0)|/f is extrapolated likewise.
    """
    rod = _tapered()
    curvature = _per_small_load(lambda state: abs(state.reaction_m)) / rod.length
    strain = curvature * rod.base_diameter / 2.0 * float(force) / rod.force_unit
    return rod.youngs_modulus * strain


def clamped_hinged_column(length: Decimal) -> float:
    """Critical load P_cr (E·I), over the length.

    A tip that sticks straight above its clamp is a hinge that can sink: x1 = 0. Our −fy there,
    extrapolated to η = 1.
    """
    # −fy is linear in 1 − η close to it.
    once, twice = (
        -solve_state(1.0, 1.0 - shortening, 0.0).reaction_fy
        for shortening in (SMALL_SHORTENING, 2.0 * SMALL_SHORTENING)
    )
    return (2.0 * once - twice) / float(length) ** 2


QUANTITIES: dict[str, Callable[[Decimal], float]] = {
    function.__name__: function
    for function in (
        conical_column,
        hinged_bar,
        post_buckled_load,
        post_buckled_deflection,
        post_buckled_shortening,
        post_buckled_deflection_under,
        post_buckled_shortening_under,
        cantilever_deflection,
        cantilever_shortening,
        cantilever_rotation,
        pulled_frame_height,
        pulled_frame_width,
        pulled_frame_slope,
        pressed_frame_height,
        pressed_frame_width,
        pressed_frame_slope,
        console_deflection,
        console_shortening,
        console_moment,
        console_stability,
        small_deflection,
        small_rotation,
        small_stress,
        clamped_hinged_column,
    )
}


# --- The states behind them. ---


@cache
def dead_load(theta: float, load: Decimal, direction: float) -> EquilibriumState:
    """Solve for the rod under a given force at its tip, which keeps its direction.

    Parameters
    ----------
    theta : float
        Taper factor.
    load : Decimal
        Force (E·I0/L²).
    direction : float
        Its inclination α in degrees, between 0 and 180.

    Returns
    -------
    EquilibriumState

    Raises
    ------
    ArithmeticError
        If the state was not found.
    """
    alpha = np.radians(direction)
    force = float(load) * np.array([np.sin(alpha), -np.cos(alpha)])

    # The tip is given by x1 and (1 − η)/x1², which hardly changes while the rod bends little.
    def state(tip: np.ndarray) -> EquilibriumState:
        return solve_state(theta, 1.0 - tip[1] * tip[0] ** 2, tip[0])

    def excess(tip: np.ndarray) -> np.ndarray:
        solved = state(tip)
        return np.array([solved.reaction_fx, solved.reaction_fy]) - force

    if load > LOAD_STEP:
        less = dead_load(theta, load - LOAD_STEP, direction)
        start = (less.x1, (1.0 - less.eta) / less.x1**2)
    else:
        # Linear theory: x1 = θ·fx/3; a cylinder's tip sinks by 3/5·x1².
        start = (theta * force[0] / 3.0, 0.6)
    found = root(excess, start, tol=1e-13)
    if not np.abs(found.fun).max() < 1e-9:
        raise ArithmeticError(f"θ = {theta}, load {load} at {direction}°: {found.message}")
    return state(found.x)


@dataclass(frozen=True, kw_only=True)
class Upright:
    """A cylinder under a vertical force.

    Attributes
    ----------
    x1, eta : float
        Position of the tip (L).
    state : StickingState
        Its forces and angles.
    """

    x1: float
    eta: float
    state: StickingState


def _upright(eta: float) -> Upright:
    curve = solve_curve(1.0, eta)
    return Upright(x1=curve.x1_init, eta=eta, state=curve.state(0.0))


def _load_ratio(rod: Upright) -> float:
    return float(rod.state.f) / conical_column(Decimal(1))


@cache
def _turned_by(tip_angle: Decimal) -> Upright:
    phi1 = np.pi / 2.0 - np.radians(float(tip_angle))
    return _upright(brentq(lambda eta: phi1 - ends(_first(eta)).phi1[0], *HEIGHTS, xtol=1e-11))


@cache
def _loaded_by(load_ratio: Decimal) -> Upright:
    load = float(load_ratio) * conical_column(Decimal(1))
    return _upright(brentq(lambda eta: -_first(eta).fy[0] - load, *HEIGHTS, xtol=1e-11))


def _first(eta: float) -> RodStates:
    """Solve the α = 0 state alone: the height is searched for without following its whole curve."""
    height, zero = np.array([eta]), np.zeros(1)
    begun = begin(rod_columns(np.ones(1), [IDEAL]), height, zero, NODES, Contact.POINT)
    return solve(begun.states, ClosingCondition.at_inclination(zero, height)).states


def _turn(state: EquilibriumState | StickingState) -> float:
    return float(np.pi / 2.0 - state.phi1)


def _tapered() -> Rod:
    return Rod(youngs_modulus=2e11, base_diameter=0.2, length=1.0)


def _per_small_load(measure: Callable[[EquilibriumState], float]) -> float:
    """Extrapolate a measure per force, which is even in the force, to none.

    Three forces remove the second and the fourth power; smaller forces would show rounding.
    """
    quarter, half, whole = (
        measure(dead_load(2.0, SMALL_LOAD / part, 90.0)) * part / float(SMALL_LOAD)
        for part in (4, 2, 1)
    )
    return (64.0 * quarter - 20.0 * half + whole) / 45.0


# --- Reading and comparing. ---


def printed(text: str, rounding: str, digit: str = "") -> Printed:
    """Read a number as it is printed.

    Parameters
    ----------
    text : str
        The number.
    rounding : str
        Name of a `Rounding`, in small letters.
    digit : str
        Size of one unit of the last digit, if it is not that of the last digit of `text`.
    """
    return Printed(
        text=text,
        digit=Decimal(digit) if digit else Decimal(1).scaleb(Decimal(text).as_tuple().exponent),
        rounding=Rounding[rounding.replace(" ", "_").upper()],
    )


def read_source(path: Path) -> Source:
    """Read the numbers of one source.

    Parameters
    ----------
    path : Path
        CSV file. Lines that begin with # say what the source is, the first of them in short.
    """
    lines = path.read_text(encoding="utf-8").splitlines()
    title, *notes = (line[1:].strip() for line in lines if line.startswith("#"))
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    numbers = tuple(
        Number(
            quantity=row["quantity"],
            argument=printed(row["argument"], row["argument_rounding"]),
            value=printed(row["value"], row["rounding"], row["digit"]),
            place=row["place"],
            known_difference=row["known_difference"],
        )
        for row in rows
    )
    return Source(title=title, notes="\n".join(notes), numbers=numbers)


def read_sources() -> list[Source]:
    """Read all sources."""
    return [read_source(path) for path in sorted(SOURCES.glob("*.csv"))]


def compare(number: Number) -> Comparison:
    """Compute what a published number corresponds to.

    Where the argument is rounded, too, ours is computed at both ends of what it can have been; it
    is taken to be monotonic in between.
    """
    quantity = QUANTITIES[number.quantity]
    ours = float(quantity(number.argument.value))
    at_ends = [ours]
    if number.argument.rounding is not Rounding.EXACT:
        at_ends += [float(quantity(Decimal(repr(end)))) for end in number.argument.bounds()]
    low, high = number.value.bounds()
    value = float(number.value.value)
    allowed = (low - value - (max(at_ends) - ours), high - value + (ours - min(at_ends)))
    return Comparison(number=number, ours=ours, allowed=allowed)


# --- The page. ---


def summary(compared: Iterable[tuple[Source, list[Comparison]]]) -> list[str]:
    """Count the verdicts of each source."""
    lines = ["| source | numbers | agree | differ |", "| --- | ---: | ---: | ---: |"]
    total = np.zeros(2, dtype=int)
    for source, comparisons in compared:
        agree = sum(comparison.agrees for comparison in comparisons)
        counts = np.array([agree, len(comparisons) - agree])
        total += counts
        lines.append(f"| {source.title} | {counts.sum()} | {counts[0]} | {counts[1]} |")
    return [*lines, f"| **all** | {total.sum()} | {total[0]} | {total[1]} |"]


def section(source: Source, comparisons: list[Comparison]) -> list[str]:
    """Say what a source is, and compare its numbers, quantity by quantity."""
    lines = ["", f"## {source.title}", "", source.notes]
    for name in dict.fromkeys(comparison.number.quantity for comparison in comparisons):
        what, _, mapping = cleandoc(QUANTITIES[name].__doc__ or "").partition("\n")
        lines += [
            "",
            f"**{what}**\n{mapping}",
            "",
            "| argument | published | ours | difference | allowed | verdict | place |",
            "| ---: | ---: | ---: | ---: | --- | --- | --- |",
            *(row(comparison) for comparison in comparisons if comparison.number.quantity == name),
        ]
    reasons = {c.number.known_difference for c in comparisons if c.number.known_difference}
    return [*lines, *(f"\nWhere it differs: {reason}." for reason in sorted(reasons))]


def row(comparison: Comparison) -> str:
    """Write one comparison."""
    number = comparison.number
    # Two digits more than the source has.
    digits = len(number.value.value.as_tuple().digits) + 2
    least, largest = comparison.allowed
    verdict = "agrees" if comparison.agrees else "**differs**"
    return (
        f"| {number.argument.text} | {number.value.text} | {comparison.ours:#.{digits}g} "
        f"| {comparison.difference:+.2e} | {least:+.2e} … {largest:+.2e} | {verdict} "
        f"| {number.place} |"
    )


def main() -> int:
    """Compare all, write the page, and name what is not as expected."""
    compared = [(source, [compare(n) for n in source.numbers]) for source in read_sources()]
    made = summary(compared)
    for source, comparisons in compared:
        made += section(source, comparisons)
    write_record("published", __doc__, "\n".join(made))
    print("\n".join(summary(compared)))
    unexpected = [c for _, comparisons in compared for c in comparisons if not c.expected]
    for comparison in unexpected:
        verdict = "agrees, which was not expected" if comparison.agrees else "differs"
        print(f"{verdict}: {comparison.number.quantity} {row(comparison)}", file=sys.stderr)
    return 1 if unexpected else 0

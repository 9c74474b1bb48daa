"""Proofs of the numbers in a study's tables, as lines of a file of enclosures.

Each function proves related rows and yields a line for each number. For a row without a proof, the
line has the reason.
"""

from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal, localcontext

import numpy as np
from flint import arb

from validation.proof import NotProvedError
from validation.proof.critical import prove_critical
from validation.proof.digits import decimals
from validation.proof.equilibrium import Equilibrium, Rod, inclined, prove, reaching
from validation.proof.flow import Effort
from validation.proof.path import Path
from validation.proof.starting import ball, load_at, path_of, prove_at, rod_of
from vibrissa.decimals import exact, spell
from vibrissa.sticking.api import solve_curve, solve_state
from vibrissa.sticking.curve import StickingCurve

# Notes for a row without an onset: proved, and not proved.
LOCKS = "the tip locks: -tan(alpha) stays below mu0 up to its maximum"
SELF_LOCKING = "self-locking: there is no onset, which is not proved"
YES_NO = {True: "yes", False: "no"}

# A line of the file by its columns; missing columns are empty. A row is given by its table and the
# keys of this table.
Line = dict[str, str]
Row = Mapping[str, str]


def lines(row: Row, numbers: Mapping[str, arb | Decimal], on_path: bool = False) -> Iterator[Line]:
    """Yield a line for each number of a row; the number lies within midpoint ± radius.

    `on_path`: whether it is also proved that the path from α = 0 leads to this state.
    """
    for quantity, value in numbers.items():
        middle, radius = decimals(value) if isinstance(value, arb) else (value, Decimal(0))
        proved = {"midpoint": spell(middle), "radius": str(radius), "on_path": YES_NO[on_path]}
        yield {**row, "quantity": quantity, **proved}


def unproved(row: Row, reason: object, on_path: bool = False) -> Line:
    """Return a line with the reason why a row has no numbers; `on_path`: whether it is proved."""
    return {**row, "on_path": YES_NO[on_path], "note": str(reason)}


def rod_lines(
    theta: Decimal, eta: Decimal, points: Sequence[tuple[Decimal, Decimal]], effort: Effort
) -> Iterator[Line]:
    """Prove the state α = 0 of a rod, its critical friction, and its periods of sticking.

    Parameters
    ----------
    theta, eta : Decimal
        Taper factor and clamp–surface distance (L).
    points : sequence of tuple of Decimal
        Pairs of μ0 and Δx0 (L).
    effort : Effort

    Yields
    ------
    Line
        Lines of the tables ``curves`` and ``stiction``.
    """
    curve = solve_curve(float(theta), float(eta))
    rod_keys = {"theta": spell(theta), "eta": spell(eta)}
    row = {"table": "curves", **rod_keys}
    rows = [
        {"table": "stiction", **rod_keys, "mu0": spell(mu0), "dx0": spell(dx0)}
        for mu0, dx0 in points
    ]
    with effort.spent():
        rod = rod_of(theta, eta, effort)
        try:
            init = prove_at(rod, inclined(arb(0)), curve, 0.0)
            if not init.bent_once():
                raise NotProvedError("it is not proved that the rod is bent once at α = 0")
        except NotProvedError as error:
            yield from (unproved(one, error) for one in (row, *rows))
            return
        yield from lines(row, {"x1_init": init.offset, **_seen(init, "init")}, on_path=True)
        onsets = curve.onset([float(mu0) for mu0, _ in points])
        slips = [mu0 for (mu0, _), at in zip(points, onsets, strict=True) if np.isfinite(at)]
        path = _path(theta, eta, init, max(slips, default=None))
        yield from _critical(rod, curve, path, row)
        for (mu0, dx0), near, one in zip(points, map(float, onsets), rows, strict=True):
            if np.isnan(near):
                locks = path.locks(ball(mu0))
                yield unproved(one, LOCKS if locks else SELF_LOCKING, locks)
                continue
            try:
                slip = prove_at(rod, inclined(ball(mu0)), curve, near)
                numbers, last = _period(rod, curve, init, slip, dx0)
                yield from lines(one, numbers, path.slips_first(slip, last))
            except NotProvedError as error:
                yield unproved(one, error)


def _path(theta: Decimal, eta: Decimal, init: Equilibrium, beyond: Decimal | None) -> Path:
    """Cover the path up to past the maximum of −tan α; return an empty path if this fails."""
    try:
        return path_of(theta, eta, init, beyond)
    except NotProvedError:
        return Path(tubes=[])


def _critical(rod: Rod, curve: StickingCurve, path: Path, row: Row) -> Iterator[Line]:
    """Prove the critical friction coefficient, if it is finite."""
    if not np.isfinite(curve.mu_lock):
        return
    try:
        critical = prove_critical(rod, load_at(curve, curve.x0_lock))
        yield from lines(row, {"mu_lock": critical.mu}, path.peaks_first(critical))
    except NotProvedError as error:
        yield unproved(row, f"mu_lock: {error}")


def _period(
    rod: Rod, curve: StickingCurve, init: Equilibrium, slip: Equilibrium, dx0: Decimal
) -> tuple[dict[str, arb | Decimal], Equilibrium]:
    """Return the numbers of a period; prove its last sticking state on the step grid."""
    x0_slip = init.offset - slip.offset
    n_steps = whole_steps(x0_slip, dx0)
    x0_max = exact(n_steps * dx0)
    last = prove_at(rod, reaching(init.offset - ball(x0_max)), curve, float(x0_max))
    numbers = {
        "x0_slip": x0_slip,
        "n_steps": Decimal(n_steps),
        "x0_max": x0_max,
        **_seen(slip, "slip"),
        **_seen(last, "last"),
        "alpha_last": last.alpha,
    }
    return numbers, last


def whole_steps(x0_slip: arb, dx0: Decimal) -> int:
    """Count the steps Δx0 up to an onset of slip.

    Raises
    ------
    NotProvedError
        If the enclosure of the onset contains the end of a step: a tie.
    """
    steps = (x0_slip / ball(dx0)).floor().unique_fmpz()
    if steps is None:
        raise NotProvedError(f"a tie: a step of {dx0} ends on the onset")
    return int(steps)


def _seen(state: Equilibrium, name: str) -> dict[str, arb | Decimal]:
    """Return the quantities of a state, by their columns in the tables."""
    return {f"f_{name}": state.f, f"phi1_{name}": state.phi1, f"reaction_m_{name}": state.load.m0}


def state_lines(
    name: str, theta: Decimal, eta: Decimal, x1: Decimal, effort: Effort
) -> Iterator[Line]:
    """Prove a single state, with its tip at (x1, η): a row of the table ``states``."""
    row = {"table": "states", "state": name}
    solved = solve_state(float(theta), float(eta), float(x1))
    near = [solved.reaction_fx, solved.reaction_fy, solved.reaction_m]
    try:
        with effort.spent():
            state = prove(rod_of(theta, eta, effort), reaching(ball(x1)), near)
            numbers = {
                "f": state.f,
                "alpha": state.alpha,
                "phi1": state.phi1,
                "reaction_m": state.load.m0,
            }
            yield from lines(row, numbers)
    except NotProvedError as error:
        yield unproved(row, error)


def cycle_lines(
    row: Row, cycles: int, curve: Mapping[str, Line], period: Mapping[str, Line]
) -> Iterator[Line]:
    """Derive the numbers of a scan's cycles from the proved numbers of its rod and its period.

    In each cycle the tip sticks up to the last step before the onset and slips one step later; the
    contact point has then moved as far as the clamp. As −tan α rises while the tip sticks, it is
    largest at the last sticking step.
    """
    if not ("x1_init" in curve and {"n_steps", "alpha_last"} <= period.keys()):
        return
    n_steps, x1, alpha = period["n_steps"], curve["x1_init"], period["alpha_last"]
    with localcontext(prec=60):
        steps, first = Decimal(n_steps["midpoint"]), Decimal(x1["midpoint"])
        for cycle in range(1, cycles + 1):
            moved = (steps + 1) * Decimal(row["dx0"])
            numbers = [
                ("steps", n_steps, steps + 1),
                ("slips", n_steps, Decimal(1)),
                ("footpoint_end", n_steps, cycle * moved),
                ("x0_largest", n_steps, steps * Decimal(row["dx0"])),
                ("x1_begin", x1, first + (cycle - 1) * moved),
                ("x1_end", x1, first + cycle * moved),
                ("alpha_smallest", alpha, Decimal(alpha["midpoint"])),
            ]
            for quantity, source, value in numbers:
                own = {"cycle": str(cycle), "quantity": quantity, "midpoint": spell(value)}
                yield {**source, **row, **own}

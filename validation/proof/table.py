"""The numbers of a study, proved: what of each row of its tables is enclosed.

Each function proves rows that belong together and returns one `Enclosure` for each number. What
cannot be proved is named with its reason.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal

import numpy as np
from flint import arb

from validation.proof import NotProvedError
from validation.proof.critical import prove_critical
from validation.proof.digits import decimals
from validation.proof.equilibrium import Equilibrium, Rod, inclined, prove, reaching
from validation.proof.flow import Effort
from validation.proof.path import Path
from validation.proof.starting import ball, load_at, path_of, prove_at, rod_of
from vibrissa.decimals import exact
from vibrissa.sticking.api import solve_curve, solve_state
from vibrissa.sticking.curve import StickingCurve

# What there is to say of a row without an onset, proved and not.
LOCKS = "the tip locks: -tan(alpha) stays below mu0 up to its maximum"
SELF_LOCKING = "self-locking: there is no onset, which is not proved"


@dataclass(frozen=True, kw_only=True)
class Enclosure:
    """A number of a table.

    Attributes
    ----------
    table : str
        As the reference tables are called.
    row : mapping of Decimal or str
        Keys of the row.
    quantity : str
        Column; empty for a row of which nothing is proved.
    midpoint, radius : Decimal or None
        The true value lies between midpoint − radius and midpoint + radius.
    note : str
        Why there is no proof; empty for an enclosure.
    on_path : bool
        Whether it is proved, too, that the path from α = 0 leads there, or that the tip locks.
    """

    table: str
    row: Mapping[str, Decimal | str]
    quantity: str = ""
    midpoint: Decimal | None = None
    radius: Decimal | None = None
    note: str = ""
    on_path: bool = False


def curve_enclosures(
    theta: Decimal,
    eta: Decimal,
    points: Sequence[tuple[Decimal, Decimal]],
    effort: Effort,
    *,
    lock: bool = False,
) -> list[Enclosure]:
    """Prove the state α = 0 of a rod, and the periods of sticking that begin there.

    Parameters
    ----------
    theta, eta : Decimal
        Taper factor and clamp–surface distance (L).
    points : sequence of tuple of Decimal
        Pairs of μ0 and Δx0 (L).
    effort : Effort
    lock : bool
        Whether to prove the critical friction coefficient, too.

    Returns
    -------
    list of Enclosure
        Of the tables ``curves`` and ``stiction``.
    """
    curve = solve_curve(float(theta), float(eta))
    key: dict[str, Decimal | str] = {"theta": theta, "eta": eta}
    rows = [{**key, "mu0": mu0, "dx0": dx0} for mu0, dx0 in points]
    with effort.spent():
        rod = rod_of(theta, eta, effort)
        try:
            init = prove_at(rod, inclined(arb(0)), curve, 0.0)
            if not init.bent_once():
                raise NotProvedError("it is not proved that the rod is bent once at α = 0")
        except NotProvedError as error:
            tables = [("curves", key), *(("stiction", row) for row in rows)]
            return [Enclosure(table=table, row=row, note=str(error)) for table, row in tables]
        columns = {"x1_init": init.offset, **_seen(init, "init")}
        found = list(_enclosed("curves", key, columns, on_path=True))
        onsets = curve.onset([float(mu0) for mu0, _ in points])
        slips = [mu0 for (mu0, _), at in zip(points, onsets, strict=True) if np.isfinite(at)]
        over = lock or len(slips) < len(points)
        path = _path(theta, eta, init, beyond=max(slips, default=None), over=over)
        if lock:
            found += _critical(rod, curve, path, key)
        for (mu0, dx0), near, row in zip(points, map(float, onsets), rows, strict=True):
            try:
                if np.isnan(near):
                    locks = path is not None and path.locks(ball(mu0))
                    note = LOCKS if locks else SELF_LOCKING
                    found.append(Enclosure(table="stiction", row=row, note=note, on_path=locks))
                    continue
                slip = prove_at(rod, inclined(ball(mu0)), curve, near)
                on_path = path is not None and path.slips_first(slip)
                columns = _period(rod, curve, init, slip, dx0)
                found += _enclosed("stiction", row, columns, on_path=on_path)
            except NotProvedError as error:
                found.append(Enclosure(table="stiction", row=row, note=str(error)))
    return found


def _path(
    theta: Decimal, eta: Decimal, init: Equilibrium, *, beyond: Decimal | None, over: bool
) -> Path | None:
    """Cover the path as `path_of` does; None where that does not succeed."""
    try:
        return path_of(theta, eta, init, beyond=beyond, over=over)
    except NotProvedError:
        return None


def _critical(
    rod: Rod, curve: StickingCurve, path: Path | None, row: Mapping[str, Decimal | str]
) -> list[Enclosure]:
    """Prove the critical friction coefficient, where there is one."""
    if not np.isfinite(curve.mu_lock):
        return []
    try:
        critical = prove_critical(rod, load_at(curve, curve.x0_lock))
    except NotProvedError as error:
        return [Enclosure(table="curves", row=row, note=f"mu_lock: {error}")]
    first = path is not None and path.peaks_first(critical)
    return list(_enclosed("curves", row, {"mu_lock": critical.mu}, on_path=first))


def _period(
    rod: Rod, curve: StickingCurve, init: Equilibrium, slip: Equilibrium, dx0: Decimal
) -> dict[str, arb | Decimal]:
    """Return the numbers of a period; prove its last state of stiction on the step grid."""
    x0_slip = init.offset - slip.offset
    n_steps = whole_steps(x0_slip, dx0)
    x0_max = exact(n_steps * dx0)
    last = prove_at(rod, reaching(init.offset - ball(x0_max)), curve, float(x0_max))
    return {
        "x0_slip": x0_slip,
        "n_steps": Decimal(n_steps),
        "x0_max": x0_max,
        **_seen(slip, "slip"),
        **_seen(last, "last"),
        "alpha_last": last.alpha,
    }


def whole_steps(x0_slip: arb, dx0: Decimal) -> int:
    """Count the steps Δx0 that do not pass an onset of slip.

    Raises
    ------
    NotProvedError
        If the enclosure of the onset holds the end of a step: a tie.
    """
    steps = (x0_slip / ball(dx0)).floor().unique_fmpz()
    if steps is None:
        raise NotProvedError(f"a tie: a step of {dx0} ends on the onset")
    return int(steps)


def _seen(state: Equilibrium, name: str) -> dict[str, arb | Decimal]:
    """Return what the tables show of a state, by their columns."""
    return {
        f"f_{name}": state.f,
        f"phi1_{name}": state.phi1,
        f"reaction_m_{name}": state.load.m0,
    }


def state_enclosures(
    name: str, theta: Decimal, eta: Decimal, x1: Decimal, effort: Effort
) -> list[Enclosure]:
    """Prove a single state in tip contact, with its contact point at (x1, η).

    Parameters
    ----------
    name : str
        Of the state in the study.
    theta, eta, x1 : Decimal
        Taper factor, clamp–surface distance and place of the tip (L).
    effort : Effort

    Returns
    -------
    list of Enclosure
        Of the table ``states``.
    """
    row = {"state": name}
    solved = solve_state(float(theta), float(eta), float(x1))
    near = [solved.reaction_fx, solved.reaction_fy, solved.reaction_m]
    try:
        with effort.spent():
            rod = rod_of(theta, eta, effort)
            state = prove(rod, reaching(ball(x1)), near)
            columns = {
                "f": state.f,
                "alpha": state.alpha,
                "phi1": state.phi1,
                "reaction_m": state.load.m0,
            }
            return list(_enclosed("states", row, columns))
    except NotProvedError as error:
        return [Enclosure(table="states", row=row, note=str(error))]


def _enclosed(
    table: str,
    row: Mapping[str, Decimal | str],
    columns: Mapping[str, arb | Decimal],
    on_path: bool = False,
) -> Iterator[Enclosure]:
    for quantity, value in columns.items():
        midpoint, radius = decimals(value) if isinstance(value, arb) else (value, Decimal(0))
        yield Enclosure(
            table=table,
            row=row,
            quantity=quantity,
            midpoint=midpoint,
            radius=radius,
            on_path=on_path,
        )

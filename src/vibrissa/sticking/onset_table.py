"""Onsets of slip of many rods at once, as a table."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.decimals import exact
from vibrissa.errors import ArgumentError
from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.mechanics.taper import MOST_TAPER
from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.numerics.batch import slices
from vibrissa.outcomes import Contact, RodSection, Status
from vibrissa.sticking.api import solve_curves
from vibrissa.sticking.curve import CURVES_AT_ONCE, curve_array
from vibrissa.sticking.periods import last_steps
from vibrissa.sticking.piece import PathState

if TYPE_CHECKING:
    import pandas as pd

# Allowed values of each argument: the least and the largest, both excluded except for theta.
_ALLOWED = {"theta": f"1 to {MOST_TAPER:g}", "mu0": "above 0", "eta": "between 0 and 1 (in L)"}


def solve_onsets(
    theta: ArrayLike,
    mu0: ArrayLike,
    eta: ArrayLike,
    dx0: ArrayLike | None = None,
    *,
    contact: str = Contact.POINT,
    mounting: Mounting = IDEAL,
    section: str = RodSection.ROUND,
    progress: bool = False,
) -> pd.DataFrame:
    """Solve many periods of sticking; see `vibrissa.solve_onset` for one.

    Each rod, a pair of theta and eta, is solved once. Rods are solved together, which takes less
    time than one after the other; results differ from those of `solve_onset` by rounding alone.

    Parameters
    ----------
    theta, mu0, eta, dx0 : array_like
        As in `vibrissa.solve_onset`; arrays that are broadcast against each other.
    contact, mounting, section : optional
        As in `vibrissa.solve_onset`, the same for all.
    progress : bool
        Whether to show the progress on a terminal.

    Returns
    -------
    DataFrame
        A row for each element of the broadcast arrays, in C order: theta, mu0, eta and dx0;
        ``status`` and ``message``; ``x0_slip``, ``n_steps``, ``x0_max``, ``mu_lock`` and
        ``residual`` as in `vibrissa.sticking.results.Onset`; and the state at the onset, with names
        such as ``reaction_m_slip``. Numbers are NaN where the tip does not slip.

    Raises
    ------
    ArgumentError
        If arrays cannot be broadcast, or a value is out of range; the message has its index.

    Examples
    --------
    >>> table = solve_onsets(theta=[1, 2], mu0=[[0.3], [0.4]], eta=0.85)
    >>> print(table[["theta", "mu0", "x0_slip"]].round(6).to_string(index=False))
     theta  mu0  x0_slip
       1.0  0.3 0.009337
       2.0  0.3 0.026336
       1.0  0.4 0.019050
       2.0  0.4 0.052838
    """
    import pandas as pd

    columns = _broadcast(theta=theta, mu0=mu0, eta=eta, dx0=np.nan if dx0 is None else dx0)
    _check(columns, has_steps=dx0 is not None)
    rods, rod = np.unique(
        np.stack([columns["theta"], columns["eta"]], axis=1), axis=0, return_inverse=True
    )
    order = np.argsort(rod.ravel(), kind="stable")
    counts = np.bincount(rod.ravel(), minlength=len(rods))
    parts = []
    with _shown(list(slices(len(rods), CURVES_AT_ONCE)), progress) as blocks:
        done = 0
        for block in blocks:
            rows = order[done : done + int(counts[block].sum())]
            done += len(rows)
            known = {name: values[rows] for name, values in columns.items()}
            found = _solved(rods[block], counts[block], known, contact, mounting, section)
            parts.append(pd.DataFrame(found | known, index=rows))
    table = pd.concat(parts).sort_index()
    if dx0 is None:
        table = table.assign(n_steps=np.nan, x0_max=np.nan)
    return table[[*columns, *(name for name in table if name not in columns)]]


def _broadcast(**arrays: ArrayLike) -> dict[str, FloatArray]:
    try:
        numbers = {name: np.asarray(values, dtype=float) for name, values in arrays.items()}
        found = np.broadcast_arrays(*numbers.values())
    except (TypeError, ValueError) as error:
        raise ArgumentError(
            f"{', '.join(arrays)} must be numbers or arrays that can be broadcast: {error}"
        ) from None
    return dict(zip(numbers, (values.ravel() for values in found), strict=True))


def _check(columns: dict[str, FloatArray], has_steps: bool) -> None:
    theta, mu0, eta, dx0 = columns.values()
    allowed = {
        "theta": (theta >= 1.0) & (theta <= MOST_TAPER),
        "mu0": (mu0 > 0.0) & np.isfinite(mu0),
        "eta": (eta > 0.0) & (eta < 1.0),
        "dx0": (dx0 > 0.0) & np.isfinite(dx0) | (not has_steps),
    }
    if not len(theta):
        raise ArgumentError("theta, mu0, eta and dx0 must have at least one value")
    for name, fine in allowed.items():
        if not fine.all():
            place = int(np.argmin(fine))
            words = _ALLOWED.get(name, "above 0")
            raise ArgumentError(
                f"{name} must be {words}, got {columns[name][place]!r} in element {place}"
            )


def _solved(
    rods: FloatArray,
    counts: IntArray,
    columns: dict[str, FloatArray],
    contact: str,
    mounting: Mounting,
    section: str,
) -> dict[str, Any]:
    """Solve some rods, and read off the onsets; `counts` has the number of rows of each rod."""
    theta, eta = rods.T.tolist()
    curves = solve_curves(theta, eta, contact, [mounting] * len(rods), section, onsets=True)
    index = np.repeat(np.arange(len(curves)), counts)
    together = curve_array(curves)
    x0_slip, found = together.outcomes(index, columns["mu0"])
    last = last_steps(x0_slip, [exact(1 if step != step else step) for step in columns["dx0"]])
    known = [status in (Status.SLIP, Status.LOCK) for status in found]
    messages = [curve.message for curve in curves]
    return {
        "status": [str(status) for status in found],
        "message": [
            "" if fine else messages[which] for which, fine in zip(index, known, strict=True)
        ],
        "x0_slip": x0_slip,
        "n_steps": last.number,
        "x0_max": last.x0,
        "mu_lock": np.array([curve.mu_lock for curve in curves])[index],
        "residual": np.array([curve.residual for curve in curves])[index],
        **_state(together.loads(index, x0_slip)),
    }


def _state(state: PathState) -> dict[str, FloatArray]:
    names = ("f", "alpha", "phi1", "s_c", "reaction_fx", "reaction_fy", "reaction_m")
    return {f"{name}_slip": getattr(state, name) for name in names}


def _shown(blocks: Sequence[slice], progress: bool) -> Any:
    """Return a context with the blocks; going through them shows the progress."""
    if not progress:
        return nullcontext(blocks)
    import typer

    return typer.progressbar(blocks, label="solving rods", file=sys.stderr)

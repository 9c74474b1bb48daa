"""Figures of points that are solved in both kinds of contact."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from vibrissa.figures import labels, style
from vibrissa.figures.kinds import kind
from vibrissa.figures.series import Series

# Column and line style of each kind of contact; colours distinguish the series.
LOCKS = {"tip contact": ("mu_lock_point", "-"), "line contact": ("mu_lock_line", "--")}


@kind(
    "models",
    columns=(
        "theta",
        "mu0",
        "eta",
        "x0_slip_point",
        "x0_slip_line",
        "penetrates",
        "status_point",
        "status_line",
        *(column for column, _ in LOCKS.values()),
    ),
)
def models(rows: pd.DataFrame) -> Figure:
    """Error of x0_slip if line contact is neglected, and μ_lock in tip and line contact, over θ."""
    figure = style.page(3.1, style.PAGE)
    errors, locks = figure.subplots(1, 2)
    series = Series(rows, "mu0")
    error = 100.0 * (rows["x0_slip_point"] / rows["x0_slip_line"] - 1.0)
    # The error is known only for points that slip in both kinds of contact.
    status = rows["status_line"].where(rows["status_line"] != "slip", rows["status_point"])
    passing = error.where(rows["penetrates"].fillna(False).astype(bool))
    rows = rows.assign(error=error, passing=passing, status=status)
    series.lines(errors, rows, "theta", "error", linewidth=0.7)
    series.lines(errors, rows, "theta", "passing", size=2.0, marker="o", label=None)
    series.gaps(errors, rows, "theta")
    text = "passes through the surface in tip contact"
    style.mean(errors, text, marker="o", color="black", markersize=2.0, linestyle="none")
    # μ_lock is infinite where the tip lifts off instead of locking: not drawn.
    rods = rows.sort_values("theta").drop_duplicates("theta").replace(np.inf, np.nan)
    for contact, (column, line) in LOCKS.items():
        look = {"linestyle": line} | style.alone(rods[column])
        locks.plot(rods["theta"], rods[column], label=contact, color="black", **look)
    errors.set(xlabel=style.TAPER, ylabel=r"error of $x_{0,\mathrm{slip}}$ in tip contact / %")
    locks.set(xlabel=style.TAPER, ylabel=style.LOCKING_FRICTION)
    style.from_zero(locks)
    labels.at_ends(errors)
    labels.at_ends(locks)
    series.explain(errors)
    return figure

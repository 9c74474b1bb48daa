"""Figures of points that are solved in both contact models."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrissa.figures import style
from vibrissa.figures.kinds import kind
from vibrissa.figures.series import Series

# Column, line and marks of each kind of contact; colours are for the series.
LOCKS = {
    "tip contact": ("mu_lock_point", "-", "black"),
    "line contact": ("mu_lock_line", "--", "white"),
}


@kind(
    "models",
    columns=(
        *("theta", "mu0", "eta", "x0_slip_point", "x0_slip_line", "penetrates"),
        *("status_point", "status_line"),
        *(column for column, *_ in LOCKS.values()),
    ),
)
def models(rows: pd.DataFrame) -> Figure:
    """Error of the point model's onset, and its locking friction, over θ."""
    figure = style.page(3.8)
    errors, locks = figure.subplots(1, 2)
    rows = rows.sort_values("theta")
    _onset_errors(errors, rows)
    curves = rows.drop_duplicates("theta")
    for contact, (column, line, inside) in LOCKS.items():
        # Infinite where the tip lifts off instead: no point to draw.
        mu_lock = curves[column].replace(np.inf, np.nan)
        look = {"color": "black", "linestyle": line, "markerfacecolor": inside}
        locks.plot(curves["theta"], mu_lock, marker=style.alone(curves), label=contact, **look)
    locks.set_ylabel(style.LOCKING_FRICTION)
    style.from_zero(locks)
    locks.legend(fontsize=8)
    locks.set_xlabel(style.TAPER)
    return figure


def _onset_errors(axes: Axes, rows: pd.DataFrame) -> None:
    """Draw the point model's relative error, with marks where its rod penetrates the surface."""
    percent = 100.0 * (rows["x0_slip_point"] / rows["x0_slip_line"] - 1.0)
    # Series of which nothing can be drawn would take the colours from the others.
    known = percent.notna().groupby(rows["mu0"]).transform("any")
    locks = (rows[["status_point", "status_line"]] == "lock").any(axis=None)
    told = style.where_it_locks(bool(locks), rows["mu0"][~known])
    marks = "marks: the rod passes through the surface in tip contact"
    axes.figure.suptitle(rf"$\eta = {rows['eta'].iloc[0]:g}$; {marks}{told}", fontsize=10)
    if not known.any():
        style.say(axes, "nowhere an onset of slip\nin both kinds of contact")
        return
    axes.set_xlabel(style.TAPER)
    axes.set_ylabel(r"error of $x_{0,\mathrm{slip}}$ in tip contact / %")
    series = Series(rows["mu0"][known], r"\mu_0")
    for mu0, points in rows.assign(percent=percent)[known].groupby("mu0"):
        color = series.color(mu0)
        axes.plot(
            points["theta"],
            points["percent"],
            color=color,
            linewidth=0.7,
            marker=style.alone(points),
            markerfacecolor="white",
            label=series.label(mu0),
        )
        axes.plot(
            points["theta"],
            points["percent"].where(points["penetrates"]),
            "o",
            markersize=series.marker_size(2.5),
            color=color,
        )
    series.explain(axes, fontsize=8)

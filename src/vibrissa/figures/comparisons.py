"""Figures of points that are solved in both contact models."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from vibrissa.figures import style
from vibrissa.figures.kinds import kind
from vibrissa.figures.series import Series
from vibrissa.figures.style import Look

# Column and line of each kind of contact; colours are for the series.
LOCKS = {"tip contact": ("mu_lock_point", "-"), "line contact": ("mu_lock_line", "--")}


@kind(
    "models",
    columns=(
        *("theta", "mu0", "eta", "x0_slip_point", "x0_slip_line", "penetrates"),
        *("status_point", "status_line"),
        *(column for column, _ in LOCKS.values()),
    ),
)
def models(rows: pd.DataFrame) -> Figure:
    """Error of the point model's onset, and its locking friction, over θ."""
    figure = style.page(2.9, style.PAGE)
    errors, locks = figure.subplots(1, 2)
    rows = rows.sort_values("theta")
    percent = 100.0 * (rows["x0_slip_point"] / rows["x0_slip_line"] - 1.0)
    series = Series(rows["mu0"], r"\mu_0")
    for mu0, points in rows.assign(percent=percent).groupby("mu0"):
        passing = points["percent"].where(points["penetrates"].fillna(False).astype(bool))
        series.line(errors, mu0, points["theta"], points["percent"], linewidth=0.7)
        look: Look = {"markersize": series.marker_size(2.0), "color": series.color(mu0)}
        errors.plot(points["theta"], passing, "o", **look)
    dot: Look = {"marker": "o", "markersize": 2.0, "color": "black", "linestyle": "none"}
    style.mean(errors, "passes through the surface in tip contact", **dot)
    if percent.isna().all():
        style.say(errors, "nowhere an onset of slip\nin both kinds of contact")
    errors.set_ylabel(r"error of $x_{0,\mathrm{slip}}$ in tip contact / %")
    curves = rows.drop_duplicates("theta")
    for contact, (column, line) in LOCKS.items():
        # Infinite where the tip lifts off instead: no point to draw.
        mu_lock = curves[column].replace(np.inf, np.nan)
        line_look: Look = {"color": "black", "linestyle": line, "marker": style.alone(curves)}
        locks.plot(curves["theta"], mu_lock, label=contact, **line_look)
    locks.set_ylabel(style.LOCKING_FRICTION)
    style.from_zero(locks)
    for panel in (errors, locks):
        panel.set_xlabel(style.TAPER)
    series.explain(errors)
    return figure

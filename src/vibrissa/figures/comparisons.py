"""Figures of points that are solved in both contact models."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrissa.figures import style
from vibrissa.figures.kinds import kind
from vibrissa.figures.series import Series
from vibrissa.figures.style import COLORS

LOCKS = {"tip contact": "mu_lock_point", "line contact": "mu_lock_line"}


@kind(
    "models",
    columns=(
        *("theta", "mu0", "eta", "x0_slip_point", "x0_slip_line", "penetrates"),
        *LOCKS.values(),
    ),
)
def models(rows: pd.DataFrame) -> Figure:
    """Error of the point model's onset, and its locking friction, over θ."""
    figure = style.page(3.8)
    errors, locks = figure.subplots(1, 2)
    rows = rows.sort_values("theta")
    _onset_errors(errors, rows)
    curves = rows.drop_duplicates("theta")
    for (contact, column), color in zip(LOCKS.items(), COLORS, strict=False):
        # Infinite where the tip lifts off instead: no point to draw.
        mu_lock = curves[column].replace(np.inf, np.nan)
        locks.plot(curves["theta"], mu_lock, color=color, marker=style.alone(curves), label=contact)
    locks.set_ylabel(style.LOCKING_FRICTION)
    locks.set_ylim(bottom=0)
    locks.legend(fontsize=8)
    for panel in (errors, locks):
        panel.set_xlabel(style.TAPER)
    return figure


def _onset_errors(axes: Axes, rows: pd.DataFrame) -> None:
    """Draw the point model's relative error, with marks where its rod penetrates the surface."""
    series = Series(rows["mu0"], r"\mu_0")
    for mu0, points in rows.groupby("mu0"):
        color = series.color(mu0)
        percent = 100.0 * (points["x0_slip_point"] / points["x0_slip_line"] - 1.0)
        axes.plot(
            points["theta"],
            percent,
            color=color,
            linewidth=0.7,
            marker=style.alone(points),
            markerfacecolor="white",
        )
        axes.plot(
            points["theta"],
            percent.where(points["penetrates"]),
            "o",
            markersize=series.marker_size(2.5),
            color=color,
            label=series.label(mu0),
        )
    axes.set_ylabel(r"error of $x_{0,\mathrm{slip}}$ in tip contact / %")
    axes.set_title(rf"$\eta = {rows['eta'].iloc[0]:g}$; marks: penetrates")
    series.explain(axes, fontsize=8)

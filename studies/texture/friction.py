"""Distribution of the apparent friction over the slope of random heights, for each tip."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

COLORS = ("#0072b2", "#d55e00", "#009e73")
DASHES = ("-", "--", ":")
# Bounds of the band, in per cent of all slips.
LOW, HIGH = 5, 95


def draw(rows: pd.DataFrame) -> Figure:
    """Draw means and bands of 90 % of the slips after the first; and the spread that they have."""
    rows = rows[(rows["ends_by"] == "slip") & (rows["period"] > 1)]
    rows = rows.assign(slope=rows["rough_deviation"] / rows["rough_correlation"])
    figure = Figure(figsize=(7.2, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    for place, (radius, ball) in enumerate(rows.groupby("tip_radius")):
        look = {"color": COLORS[place], "linestyle": DASHES[place]}
        found = ball.groupby("slope")["apparent_friction"]
        low, high = found.quantile(LOW / 100), found.quantile(HIGH / 100)
        name = "sharp tip" if radius == 0.0 else f"ball of {radius:g} $L$"
        left.plot(found.mean().index, found.mean(), label=name, **look)
        left.fill_between(low.index, low, high, color=COLORS[place], alpha=0.15, linewidth=0)
        right.plot(found.std().index, found.std(), marker="o", markersize=3, **look)
    mu0, slopes = rows["mu0"].iloc[0], np.linspace(0.0, rows["slope"].max(), 50)
    left.plot(slopes, np.full(50, mu0), color="#888888", linewidth=0.6)
    right.plot(slopes, (1.0 + mu0**2) * slopes, color="#888888", linewidth=0.6)
    right.annotate(
        r"$(1 + \mu_0^2)\,\Delta_q$", (slopes[30], 1.03 * (1.0 + mu0**2) * slopes[30]), ha="right"
    )
    left.set(xlabel=r"slope $\Delta_q$ of the heights", ylabel="apparent friction $|F_x/F_y|$")
    right.set(xlabel=r"slope $\Delta_q$ of the heights", ylabel="standard deviation of $|F_x/F_y|$")
    right.set(xlim=(0.0, None), ylim=(0.0, None))
    figure.legend(loc="outside lower center", ncols=4, frameon=False)
    return figure

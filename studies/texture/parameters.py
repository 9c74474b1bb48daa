"""Parameters of roughness from the places at which the tip rests, over the length of the scan."""

from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

COLORS = {"short": "#009e73", "middle": "#d55e00", "long": "#0072b2"}
DASHES = {"free": "-", "kinetic": "--"}
LENGTHS = np.arange(0.1, 2.01, 0.1)


class Parameters(NamedTuple):
    """Rq, Ra and RSm of a profile (L)."""

    rq: float
    ra: float
    rsm: float


def true(rows: pd.DataFrame) -> Parameters:
    """Parameters of normally distributed heights with a Gaussian correlation.

    RSm is the mean distance of places at which the profile rises through its mean line.
    """
    rq, correlation = rows["rough_deviation"].iloc[0], rows["rough_correlation"].iloc[0]
    return Parameters(rq=rq, ra=rq * np.sqrt(2.0 / np.pi), rsm=2.0 * np.pi * correlation)


def seen(x: np.ndarray, height: np.ndarray) -> Parameters:
    """Parameters of the heights at the places of rest, with straight lines between them."""
    above = height - height.mean()
    rises = int(((above[:-1] < 0.0) & (above[1:] >= 0.0)).sum())
    rsm = (x[-1] - x[0]) / rises if rises else np.nan
    return Parameters(rq=above.std(), ra=np.abs(above).mean(), rsm=rsm)


def ratios(scan: pd.DataFrame) -> pd.DataFrame:
    """Parameters over their true values, for parts of a scan of different lengths."""
    scan, known = scan.sort_values("period"), true(scan)
    found = {}
    for length in LENGTHS:
        part = scan[scan["footpoint_begin"] < length]
        if len(part) > 2 and length < scan["footpoint_last"].max() + 0.05:
            values = seen(part["x1"].to_numpy(), part["height"].to_numpy())
            found[round(length, 6)] = [
                one / other for one, other in zip(values, known, strict=True)
            ]
    return pd.DataFrame.from_dict(found, orient="index", columns=Parameters._fields)


def draw(rows: pd.DataFrame) -> Figure:
    """Draw the mean over all seeds, and bands from the least to the largest for the law free."""
    figure = Figure(figsize=(7.2, 3.0), layout="constrained")
    panels = figure.subplots(1, 3, sharex=True)
    for (law, surface), scans in rows.groupby(["law", "surface"], sort=False):
        each = [ratios(scan) for _, scan in scans.groupby("rough_seed")]
        all_of = pd.concat(each, keys=range(len(each))).groupby(level=1)
        mean, low, high = all_of.mean(), all_of.min(), all_of.max()
        distance = true(scans).rsm
        name = f"RSm = {distance:.3f} $L$, {law}"
        for panel, column in zip(panels, Parameters._fields, strict=True):
            panel.plot(
                mean.index, mean[column], color=COLORS[surface], linestyle=DASHES[law], label=name
            )
            if law == "free":
                band = {"color": COLORS[surface], "alpha": 0.12, "linewidth": 0}
                panel.fill_between(mean.index, low[column], high[column], **band)
    panels[2].set_yscale("log")
    for panel in panels[:2]:
        panel.set_ylim(0.0, 1.3)
    for panel, name in zip(panels, ("$R_q$", "$R_a$", "$R_{Sm}$"), strict=True):
        panel.axhline(1.0, color="#888888", linewidth=0.6)
        panel.set(xlabel="length of the scan / $L$", ylabel=f"{name} seen / {name} true")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure

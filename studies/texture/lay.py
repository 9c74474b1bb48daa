"""Distance of slips over the angle between the motion and the direction across waves."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from vibrissa.scanning.phase_locking import locking_of, settled_rests

COLORS = {"free": "#0072b2", "kinetic": "#d55e00"}


def rests(scan: pd.DataFrame) -> np.ndarray:
    """Places at which the tip rests after slips (L), without those at the start of a scan."""
    slips = scan[scan["ends_by"] == "slip"].sort_values("period")
    return settled_rests(slips["footpoint_slip"].to_numpy(), slips["x1_rest"].to_numpy())


def draw(rows: pd.DataFrame) -> Figure:
    """Draw mean distances; full marks where the slips repeat with the waves."""
    figure = Figure(figsize=(3.5, 3.0), layout="constrained")
    panel = figure.subplots()
    wavelength = rows["wave_wavelength"].iloc[0]
    for (law, lay), scan in rows.groupby(["law", "lay"]):
        x = rests(scan)
        if len(x) < 2:
            continue
        repeats = locking_of(x, wavelength / np.cos(lay)) is not None
        fill = COLORS[law] if repeats else "white"
        panel.plot(
            np.degrees(lay), np.diff(x).mean(), "o", ms=3.5, color=COLORS[law], mfc=fill, mew=0.8
        )
    angles = np.linspace(0.0, rows["lay"].max(), 100)
    for slips in (1, 2, 3):
        line = wavelength / np.cos(angles) / slips
        text = r"$\lambda/\cos$" if slips == 1 else rf"$\lambda/({slips}\cos)$"
        panel.plot(np.degrees(angles), line, color="#888888", linewidth=0.6)
        panel.annotate(
            text, (np.degrees(angles[70]), line[70]), fontsize=7, ha="right", va="bottom"
        )
    for law, color in COLORS.items():
        panel.plot([], [], "o", ms=3.5, color=color, label=law)
    panel.plot([], [], "o", ms=3.5, color="black", mfc="white", label="no repetition")
    most = rows["slip_length"].quantile(0.98)
    panel.set(xlabel="angle to the lay / degree", ylabel="mean distance of slips / $L$")
    panel.set_ylim(0.0, 1.6 * most)
    panel.legend(fontsize=7, frameon=False)
    return figure

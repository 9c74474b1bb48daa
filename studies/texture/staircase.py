"""Mean number of slips in a wave over its wavelength: plateaus where slips lock to the wave."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from vibrissa.scanning.phase_locking import locking_of, settled_rests

COLORS = ("#999999", "#56b4e9", "#0072b2", "#009e73", "#e69f00", "#d55e00")
LAWS = {"free": "law free", "kinetic": r"law kinetic, $\mu_k/\mu_0 = 0.8$"}


def rests(scan: pd.DataFrame) -> np.ndarray:
    """Places at which the tip rests after slips (L), without those at the start of a scan."""
    slips = scan[scan["ends_by"] == "slip"].sort_values("period")
    return settled_rests(slips["footpoint_slip"].to_numpy(), slips["x1_rest"].to_numpy())


def draw(rows: pd.DataFrame) -> Figure:
    """Draw a panel for each slip law; full marks where slips repeat with the wave."""
    figure = Figure(figsize=(7.2, 3.2), layout="constrained")
    panels = figure.subplots(1, len(LAWS))
    for panel, (law, title) in zip(panels, LAWS.items(), strict=True):
        of_law = rows[rows["law"] == law]
        for color, (amplitude, scans) in zip(
            COLORS, of_law.groupby("wave_amplitude"), strict=False
        ):
            found = []
            for wavelength, scan in scans.groupby("wave_wavelength"):
                x = rests(scan)
                if scan["ends_by"].iloc[-1] == "path" and len(x) > 1:
                    slips = wavelength * (len(x) - 1) / (x[-1] - x[0])
                    found.append((wavelength, slips, locking_of(x, wavelength) is not None))
            wavelengths, slips, repeat = map(np.array, zip(*found, strict=True))
            label = rf"amplitude {1e4 * amplitude:g}$\cdot 10^{{-4}} L$"
            panel.plot(wavelengths, slips, color=color, linewidth=0.8, label=label)
            panel.plot(wavelengths[repeat], slips[repeat], "o", ms=3, color=color)
        panel.set_title(title, fontsize=8, loc="left", pad=3)
        panel.set(xlabel="wavelength / $L$", ylabel="slips in a wave, mean", ylim=(0.0, None))
        for level in (1, 2):
            panel.axhline(level, color="#bbbbbb", linewidth=0.5, zorder=0)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure

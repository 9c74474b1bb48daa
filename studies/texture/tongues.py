"""Map of the slips that repeat with a wave, over its wavelength and amplitude."""

from math import gcd

import numpy as np
import pandas as pd
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from vibrissa.scanning.phase_locking import locking_of, settled_rests

COLORS = {
    "1 : 1": "#0072b2",
    "1 : 1, after several": "#56b4e9",
    "2 : 1": "#d55e00",
    "3 : 1": "#009e73",
    "4 : 1": "#cc79a7",
    "1 : 2": "#003f66",
    "3 : 2": "#f0e442",
}
OTHER, NONE, HOLDS = "#e69f00", "#dddddd", "#444444"
SHOWN = [*COLORS, "other ratio", "no repetition", "the tip locks"]
LAWS = {"free": "law free", "kinetic": r"law kinetic, $\mu_k/\mu_0 = 0.8$"}


def rests(scan: pd.DataFrame) -> np.ndarray:
    """Places at which the tip rests after slips (L), without those at the start of a scan."""
    slips = scan[scan["ends_by"] == "slip"].sort_values("period")
    return settled_rests(slips["footpoint_slip"].to_numpy(), slips["x1_rest"].to_numpy())


def _kind(rows: pd.DataFrame) -> int:
    """Place of a scan's kind in `SHOWN`."""
    if rows["status"].iloc[0] != "slip" or rows["ends_by"].iloc[-1] != "path":
        return SHOWN.index("the tip locks")
    found = locking_of(rests(rows), rows["wave_wavelength"].iloc[0])
    if found is None:
        return SHOWN.index("no repetition")
    common = gcd(*found)
    name = f"{found.slips // common} : {found.waves // common}"
    if common > 1 and name == "1 : 1":
        return SHOWN.index("1 : 1, after several")
    return SHOWN.index(name if name in COLORS else "other ratio")


def draw(rows: pd.DataFrame) -> Figure:
    """Draw a map for each slip law."""
    keys = ["law", "wave_amplitude", "wave_wavelength"]
    kinds = {key: _kind(scan) for key, scan in rows.groupby(keys)}
    found = pd.Series(kinds).rename_axis(keys)
    figure = Figure(figsize=(7.2, 5.2), layout="constrained")
    panels = figure.subplots(len(LAWS), 1, sharex=True, sharey=True)
    colors = ListedColormap([*COLORS.values(), OTHER, NONE, HOLDS])
    for panel, (law, title) in zip(panels, LAWS.items(), strict=True):
        table = found[law].unstack("wave_wavelength")
        places = np.arange(len(table) + 1) - 0.5
        half = 0.5 * np.diff(table.columns).mean()
        across = np.append(table.columns - half, table.columns[-1] + half)
        panel.pcolormesh(across, places, table, cmap=colors, vmin=-0.5, vmax=len(SHOWN) - 0.5)
        panel.set_yticks(range(len(table)), [f"{1e4 * value:g}" for value in table.index])
        panel.set_title(title, fontsize=8, loc="left", pad=3)
        panel.set_ylabel(r"amplitude / $10^{-4} L$")
    panels[-1].set_xlabel("wavelength / $L$")
    kept = [place for place in range(len(SHOWN)) if (found == place).any()]
    handles = [Patch(color=colors(place), label=SHOWN[place]) for place in kept]
    title = "slips : waves"
    figure.legend(handles=handles, loc="outside right center", title=title, frameon=False)
    return figure

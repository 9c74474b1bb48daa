"""Figures of what an inclined or yielding clamp, a curved rod and an oblique stage change."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrissa.figures import style
from vibrissa.figures.kinds import POINT, kind
from vibrissa.figures.series import Series
from vibrissa.figures.style import Look

# Label of each axis of the mounting, and the unit in which it is shown.
AXES = {
    "clamp_angle": (r"inclination of the clamp $\beta$ / degree", np.degrees(1.0)),
    "clamp_compliance": (r"compliance of the clamp $c$ / $L/(E I_0)$", 1.0),
    "curvature": (r"natural curvature $\kappa_0 L$", 1.0),
    "stage_angle": (r"angle of the stage $\delta$ / degree", np.degrees(1.0)),
}
PANELS = {
    "mu_lock": r"lock $\mu_\mathrm{lock}$",
    "x0_slip": r"onset of slip $x_{0,\mathrm{slip}}$ / $L$",
    "reaction_fx_slip": r"$f_x$ at the onset / $E I_0/L^2$",
    "reaction_fy_slip": r"$f_y$ at the onset / $E I_0/L^2$",
    "reaction_m_slip": r"$m(0)$ at the onset / $E I_0/L$",
}
HEIGHT = r"clamp–surface distance $\eta$"


def _varied(rows: pd.DataFrame) -> str:
    """Return the axis of the mounting that has several values."""
    return max(AXES, key=lambda axis: rows[axis].nunique())


@kind("mounting", columns=(*POINT, *AXES, *PANELS))
def mounting(rows: pd.DataFrame) -> Figure:
    """Lock, onset of slip and loads on the clamp over one axis of the mounting, for each θ."""
    over = _varied(rows)
    label, unit = AXES[over]
    # Where every tip locks there is no onset to be drawn, and where none locks, no lock.
    shown = {column: name for column, name in PANELS.items() if np.isfinite(rows[column]).any()}
    if not shown:
        return style.message("no tip slips, and none locks")
    columns = min(len(shown), 3)
    lines = -(-len(shown) // columns)
    figure = style.page(0.7 + 1.8 * lines, style.PAGE)
    panels = figure.subplots(lines, columns, sharex=True, squeeze=False).ravel()
    series = Series(rows["theta"], r"\theta")
    for panel, (column, name) in zip(panels, shown.items(), strict=False):
        for theta, points in rows.sort_values(over).groupby("theta"):
            # Infinite where the tip lifts off instead: no point to draw.
            values = points[column].replace(np.inf, np.nan)
            series.line(panel, theta, points[over] * unit, values)
        if rows[over].min() < 0.0 < rows[over].max():
            panel.axvline(0.0, color=style.SURFACE, linewidth=0.6, linestyle=":")
        panel.set_ylabel(name)
    for panel in panels[len(shown) :]:
        panel.set_axis_off()
    for panel in panels[: len(shown)][-columns:]:
        panel.tick_params(labelbottom=True)
        panel.set_xlabel(label)
    # Where a cell is empty the legend stands in it.
    cell: Look = {"loc": "center", "bbox_to_anchor": (0.86, 0.26), "ncols": 1}
    series.explain(list(panels), **(cell if len(panels) > len(shown) else {}))
    return figure


@kind("change", columns=(*POINT, *AXES, "mu_lock", "x0_slip"))
def change(rows: pd.DataFrame) -> Figure:
    """Change of lock and onset by one deviation of the mounting, in per cent, over θ and η."""
    over = _varied(rows)
    mounted = rows[over] != 0.0
    pairs = rows[~mounted].merge(rows[mounted], on=["theta", "eta"], suffixes=("_ideal", ""))
    figure = style.page(2.6, style.PAGE)
    shown = {"mu_lock": r"\mu_\mathrm{lock}", "x0_slip": r"x_{0,\mathrm{slip}}"}
    panels = figure.subplots(1, 2, sharey=True)
    for panel, (column, symbol) in zip(panels, shown.items(), strict=True):
        pairs["change"] = 100.0 * (pairs[column] / pairs[f"{column}_ideal"] - 1.0)
        values = pairs.pivot(index="eta", columns="theta", values="change")
        _map(panel, values, f"change of ${symbol}$ / %")
        panel.set_xlabel(style.TAPER)
    panels[0].set_ylabel(HEIGHT)
    return figure


@kind("versus", columns=(*POINT, *AXES, "mu_lock"))
def versus(rows: pd.DataFrame) -> Figure:
    """Lock of each cone less that of the cylinder, over one axis of the mounting and η."""
    label, unit = AXES[_varied(rows)]
    locks = rows.assign(at=rows[_varied(rows)] * unit).replace(np.inf, np.nan)
    least, *tapers = sorted(locks["theta"].unique())
    tables = {
        theta: part.pivot(index="eta", columns="at", values="mu_lock")
        for theta, part in locks.groupby("theta")
    }
    figure = style.page(2.5, style.PAGE)
    panels = np.atleast_1d(figure.subplots(1, len(tapers), sharey=True))
    difference = rf"$\mu_\mathrm{{lock}}(\theta) - \mu_\mathrm{{lock}}({least:g})$"
    for panel, theta in zip(panels, tapers, strict=True):
        ahead = tables[theta] - tables[least]
        _map(panel, ahead, difference if theta == tapers[-1] else "")
        if min(ahead.shape) > 1 and ahead.min(axis=None) < 0.0 < ahead.max(axis=None):
            panel.contour(ahead.columns, ahead.index, ahead, levels=[0.0], colors="black")
        panel.set_title(rf"$\theta = {theta:g}$")
        panel.set_xlabel(label)
    panels[0].set_ylabel(HEIGHT)
    return figure


def _map(panel: Axes, values: pd.DataFrame, label: str) -> None:
    """Draw values over rows and columns: red above zero, blue below, grey where there is none."""
    bound = float(np.nanmax(np.abs(values.to_numpy()))) if values.notna().any(axis=None) else 1.0
    panel.set_facecolor("#cccccc")
    columns, index = style.cells(values.columns), style.cells(values.index)
    look: Look = {"cmap": "RdBu_r", "vmin": -bound, "vmax": bound, "rasterized": True}
    panel.figure.colorbar(panel.pcolormesh(columns, index, values, **look), ax=panel, label=label)

"""Figures of the effects of an inclined or yielding clamp, a curved rod and an oblique stage."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from vibrissa.figures import style
from vibrissa.figures.kinds import POINT, kind
from vibrissa.figures.series import Series

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
CHANGED = {"mu_lock": r"\mu_\mathrm{lock}", "x0_slip": r"x_{0,\mathrm{slip}}"}
IN_A_ROW = 3
HEIGHT = r"clamp–surface distance $\eta$"


def _over(rows: pd.DataFrame) -> tuple[pd.DataFrame, str]:
    """Return rows with a new column ``over``, the varied mounting parameter, and its axis label."""
    varied = max(AXES, key=lambda axis: rows[axis].nunique())
    label, unit = AXES[varied]
    # μ_lock is infinite where the tip lifts off instead of locking: not drawn.
    return rows.assign(over=rows[varied] * unit).replace(np.inf, np.nan), label


@kind("mounting", columns=(*POINT, *AXES, *PANELS))
def mounting(rows: pd.DataFrame) -> Figure:
    """μ_lock, onset of slip and loads on the clamp over a mounting parameter, for each θ."""
    rows, label = _over(rows)
    # If all tips lock, there is no onset to draw; if none locks, there is no μ_lock.
    shown = [column for column in PANELS if rows[column].notna().any()]
    if not shown:
        return style.message("no tip slips, and none locks")
    columns = min(len(shown), IN_A_ROW)
    lines = -(-len(shown) // columns)
    figure = style.page(0.7 + 1.8 * lines, style.PAGE)
    panels = list(figure.subplots(lines, columns, sharex=True, squeeze=False).flat)
    series = Series(rows, "theta")
    for panel, column in zip(panels, shown, strict=False):
        series.lines(panel, rows, "over", column)
        if rows["over"].min() < 0.0 < rows["over"].max():
            panel.axvline(0.0, color=style.SURFACE, linewidth=0.6, linestyle=":")
        panel.set_ylabel(PANELS[column])
    for panel in panels[len(shown) :]:
        panel.set_axis_off()
    for panel in panels[: len(shown)][-columns:]:
        panel.tick_params(labelbottom=True)
        panel.set_xlabel(label)
    # The legend goes into an empty cell, if there is one.
    cell: style.Look = {"loc": "center", "bbox_to_anchor": (0.86, 0.26), "ncols": 1}
    series.explain(panels, **(cell if len(panels) > len(shown) else {}))
    return figure


@kind("change", columns=(*POINT, *AXES, "mu_lock", "x0_slip"))
def change(rows: pd.DataFrame) -> Figure:
    """Change of μ_lock and x0_slip (%) due to a deviation of the mounting, over θ and η."""
    rows, _ = _over(rows)
    (deviation,) = set(rows["over"]) - {0.0}
    maps = {}
    for column, symbol in CHANGED.items():
        table = rows.pivot(index="eta", columns=["over", "theta"], values=column)
        maps[f"change of ${symbol}$ / %"] = 100.0 * (table[deviation] / table[0.0] - 1.0)
    return _maps(maps, style.TAPER)


@kind("versus", columns=(*POINT, *AXES, "mu_lock"))
def versus(rows: pd.DataFrame) -> Figure:
    """Difference of μ_lock from its value at the smallest θ, over η and a mounting parameter."""
    rows, label = _over(rows)
    table = rows.pivot(index="eta", columns=["theta", "over"], values="mu_lock")
    least, *tapers = sorted(set(rows["theta"]))
    lock = CHANGED["mu_lock"]
    names = {theta: f"${lock}({theta:g}) - {lock}({least:g})$" for theta in tapers}
    return _maps({name: table[theta] - table[least] for theta, name in names.items()}, label)


def _maps(tables: Mapping[str, pd.DataFrame], label: str) -> Figure:
    """Draw maps of tables over η and a quantity: red above zero, blue below, grey if unknown."""
    columns = min(len(tables), 3)
    lines = -(-len(tables) // columns)
    figure = style.page(2.6 * lines, style.PAGE)
    grid = figure.subplots(lines, columns, sharey=True, squeeze=False)
    for panel in grid.flat[len(tables) :]:
        panel.set_visible(False)
    panels = grid.flat[: len(tables)]
    for panel, (name, table) in zip(panels, tables.items(), strict=True):
        low, high = table.min(axis=None), table.max(axis=None)
        bound = table.abs().max(axis=None)
        bound = bound if bound > 0.0 else 1.0
        look: style.Look = {"cmap": "RdBu_r", "vmin": -bound, "vmax": bound, "rasterized": True}
        across, index = style.cells(table.columns), style.cells(table.index)
        figure.colorbar(panel.pcolormesh(across, index, table, **look), ax=panel, label=name)
        if min(table.shape) > 1 and low < 0.0 < high:
            panel.contour(table.columns, table.index, table, levels=[0.0], colors="black")
        panel.set_facecolor("#cccccc")
        panel.set_xlabel(label)
    for panel in panels[::columns]:
        panel.set_ylabel(HEIGHT)
    return figure

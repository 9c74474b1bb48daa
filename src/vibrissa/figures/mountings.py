"""Figures of what an inclined or yielding clamp, a curved rod and an oblique stage change."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
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


@kind("mounting", columns=(*POINT, *AXES, *PANELS))
def mounting(rows: pd.DataFrame) -> Figure:
    """Lock, onset of slip and loads on the clamp over one axis of the mounting, for each θ."""
    over = max(AXES, key=lambda axis: rows[axis].nunique())
    label, unit = AXES[over]
    # Where every tip locks there is no onset to be drawn, and where none locks, no lock.
    shown = {column: name for column, name in PANELS.items() if np.isfinite(rows[column]).any()}
    lines = -(-len(shown) // 2)
    figure = style.page(1.2 + 2.0 * lines)
    panels = figure.subplots(lines, min(len(shown), 2), sharex=True, squeeze=False).ravel()
    series = Series(rows["theta"], r"\theta")
    for panel, (column, name) in zip(panels, shown.items(), strict=False):
        for theta, points in rows.sort_values(over).groupby("theta"):
            # Infinite where the tip lifts off instead: no point to draw.
            values = points[column].replace(np.inf, np.nan)
            panel.plot(
                points[over] * unit,
                values,
                color=series.color(theta),
                marker=style.alone(points),
                label=series.label(theta),
            )
        if rows[over].min() < 0.0 < rows[over].max():
            panel.axvline(0.0, color=style.SURFACE, linewidth=0.6, linestyle=":")
        panel.set_ylabel(name)
    for panel in panels[len(shown) :]:
        panel.remove()
    for panel in panels[: len(shown)][-2:]:
        panel.tick_params(labelbottom=True)
    first = rows.iloc[0]
    slips = "onset of slip" if "x0_slip" in shown else "no tip slips"
    locks = "" if "mu_lock" in shown else "; no tip locks"
    title = rf"$\eta = {first['eta']:g}$; {slips} at $\mu_0 = {first['mu0']:g}${locks}"
    if series.few:
        handles, _ = panels[0].get_legend_handles_labels()
        figure.legend(handles=handles, loc="outside upper center", ncols=4, fontsize=9, title=title)
    else:
        figure.suptitle(title)
        series.colorbar(panels[0])
    figure.supxlabel(label, fontsize=10)
    return figure


@kind("change", columns=(*POINT, *AXES, "mu_lock", "x0_slip"))
def change(rows: pd.DataFrame) -> Figure:
    """Change of lock and onset by one deviation of the mounting, in per cent, over θ and η."""
    over = max(AXES, key=lambda axis: rows[axis].nunique())
    deviation = rows[over].to_numpy()[np.abs(rows[over]).argmax()]
    ideal, mounted = rows[rows[over] == 0.0], rows[rows[over] == deviation]
    pairs = ideal.merge(mounted, on=["theta", "eta"], suffixes=("_ideal", ""))
    label, unit = AXES[over]
    figure = style.page(3.4)
    shown = {"mu_lock": r"\mu_\mathrm{lock}", "x0_slip": r"x_{0,\mathrm{slip}}"}
    panels = figure.subplots(1, 2, sharey=True)
    for panel, (column, symbol) in zip(panels, shown.items(), strict=True):
        pairs["change"] = 100.0 * (pairs[column] / pairs[f"{column}_ideal"] - 1.0)
        values = pairs.pivot(index="eta", columns="theta", values="change")
        _map(panel, values, f"change of ${symbol}$ / %")
        panel.set_xlabel(style.TAPER)
    panels[0].set_ylabel(r"clamp–surface distance $\eta$")
    name = label.split(" / ")[0]
    figure.suptitle(f"{name} = {deviation * unit:.3g}{' degree' if 'degree' in label else ''}")
    return figure


@kind("versus", columns=(*POINT, *AXES, "mu_lock"))
def versus(rows: pd.DataFrame) -> Figure:
    """Lock of each cone less that of the cylinder, over one axis of the mounting and η."""
    over = max(AXES, key=lambda axis: rows[axis].nunique())
    label, unit = AXES[over]
    locks = rows.assign(at=rows[over] * unit).replace(np.inf, np.nan)
    least, *tapers = sorted(locks["theta"].unique())
    tables = {
        theta: part.pivot(index="eta", columns="at", values="mu_lock")
        for theta, part in locks.groupby("theta")
    }
    figure = style.page(3.2)
    panels = np.atleast_1d(figure.subplots(1, len(tapers), sharey=True))
    for panel, theta in zip(panels, tapers, strict=True):
        ahead = tables[theta] - tables[least]
        _map(panel, ahead, "")
        if min(ahead.shape) > 1 and ahead.min(axis=None) < 0.0 < ahead.max(axis=None):
            panel.contour(ahead.columns, ahead.index, ahead, levels=[0.0], colors="black")
        panel.set_title(rf"$\theta = {theta:g}$", fontsize=9)
    panels[0].set_ylabel(r"clamp–surface distance $\eta$")
    figure.supxlabel(label, fontsize=10)
    figure.suptitle(rf"$\mu_\mathrm{{lock}}(\theta) - \mu_\mathrm{{lock}}({least:g})$", fontsize=10)
    return figure


def _map(panel: Axes, values: pd.DataFrame, label: str) -> None:
    """Draw values over rows and columns: red above zero, blue below, grey where there is none."""
    bound = float(np.nanmax(np.abs(values.to_numpy()))) if values.notna().any(axis=None) else 1.0
    panel.set_facecolor("#cccccc")
    columns, index = style.cells(values.columns), style.cells(values.index)
    mesh = panel.pcolormesh(columns, index, values, cmap="RdBu_r", vmin=-bound, vmax=bound)
    bar = panel.figure.colorbar(mesh, ax=panel, label=label)
    bar.ax.tick_params(labelsize=8)

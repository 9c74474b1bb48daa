"""Figures of the effects of an inclined or yielding clamp, a curved rod and an oblique stage."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.patches import Rectangle

from vibrissa.figures import labels, style
from vibrissa.figures.kinds import POINT, kind
from vibrissa.figures.series import QUANTITIES, Series
from vibrissa.numerics.arrays import FloatArray

# Label of each axis of the mounting, and the unit in which it is shown.
AXES = {
    "clamp_angle": (r"inclination of the clamp $\beta$ / degree", np.degrees(1.0)),
    "clamp_compliance": (r"compliance of the clamp $c$ / $L/(E I_0)$", 1.0),
    "curvature": (r"natural curvature $\kappa_0 L$", 1.0),
    "stiffening": (r"stiffening $c_1$", 1.0),
    "bore": (r"bore $b$ / $d_0$", 1.0),
    "stage_angle": (r"angle of the stage $\delta$ / degree", np.degrees(1.0)),
}
LOADS = ("reaction_fx_slip", "reaction_fy_slip", "reaction_m_slip")
SHORT = {
    "mu_lock": r"$\mu_\mathrm{lock}$",
    "x0_slip": r"$x_{0,\mathrm{slip}}$",
    "reaction_fx_slip": "$f_x$ (% of $f$)",
    "reaction_fy_slip": "$f_y$ (% of $f$)",
    "reaction_m_slip": "$m$ (% of $fL$)",
}
# Step of each axis in the table of slopes, in the unit of the axis and in words.
STEPS = {
    "clamp_angle": (np.radians(1.0), "clamp by 1°"),
    "clamp_compliance": (0.1, "compliance by 0.1"),
    "curvature": (0.1, "curvature by 0.1"),
    "stiffening": (0.1, "modulus at the tip by 10 %"),
    "bore": (0.1, "bore by 0.1 d0"),
    "stage_angle": (np.radians(1.0), "stage by 1°"),
}
# A line bends if it leaves its tangent by more (%); number of those that are drawn; their shade.
BENT, MOST_BENT, BENDS = 15.0, 6, "#f6dfc8"
# Width of the names of the rows, in columns of the table.
FIRST_COLUMN = 7.2
# Values above CLIPPED times this quantile of the values are beyond the scale.
USUAL, CLIPPED = 0.98, 1.5
BORDER: style.Look = {"color": "black", "linewidth": 1.2, "linestyle": (0, (2, 1))}
CHANGED = {"mu_lock": r"\mu_\mathrm{lock}", "x0_slip": r"x_{0,\mathrm{slip}}"}
IN_A_ROW = 3
HEIGHT = r"clamp–surface distance $\eta$"


def _over(rows: pd.DataFrame) -> tuple[pd.DataFrame, str]:
    """Return rows with a new column ``over``, the varied mounting parameter, and its axis label."""
    varied = max(AXES, key=lambda axis: rows[axis].nunique())
    label, unit = AXES[varied]
    # μ_lock is infinite where the tip lifts off instead of locking: not drawn.
    return rows.assign(over=rows[varied] * unit).replace(np.inf, np.nan), label


@kind("mounting", columns=(*POINT, *AXES, *QUANTITIES))
def mounting(rows: pd.DataFrame) -> Figure:
    """μ_lock, onset of slip and loads on the clamp over a mounting parameter, for each θ."""
    rows, label = _over(rows)
    # If all tips lock, there is no onset to draw; if none locks, there is no μ_lock.
    shown = [column for column in QUANTITIES if rows[column].notna().any()]
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
        panel.set_ylabel(QUANTITIES[column])
    for panel in panels[len(shown) :]:
        panel.set_axis_off()
    for panel in panels[: len(shown)][-columns:]:
        panel.tick_params(labelbottom=True)
        panel.set_xlabel(label)
    # The legend goes into an empty cell, if there is one.
    cell: style.Look = {"loc": "center", "bbox_to_anchor": (0.86, 0.26), "ncols": 1}
    series.explain(panels, **(cell if len(panels) > len(shown) else {}))
    return figure


@kind("slopes", columns=(*POINT, *AXES, *QUANTITIES, "grid"))
def slopes(rows: pd.DataFrame) -> Figure:
    """Table of the slopes of μ_lock, onset and loads over each mounting axis, and lines that bend.

    Each grid of the rows varies one axis of the mounting. Slopes are those at the ideal mounting.
    """
    responses = [
        _response(points, axis, eta, quantity)
        for axis in AXES
        for _, group in rows.groupby("grid")
        if group[axis].nunique() > 1
        for eta, points in group.groupby("eta")
        for quantity in QUANTITIES
    ]
    known = [response for response in responses if response.slopes.notna().any()]
    if not known:
        return style.message("no tip slips, and none locks, in the ideal mounting")
    bent = sorted((one for one in known if one.most_bent > BENT), key=lambda one: -one.most_bent)
    bent = bent[:MOST_BENT]
    lines = -(-len(bent) // IN_A_ROW)
    sheets = len({(one.axis, one.eta) for one in known})
    sizes = (0.19 * (sheets + 2.5), 1.75 * lines + 0.05)
    figure = style.page(sum(sizes), style.PAGE)
    if not lines:
        _table(figure, known)
        return figure
    parts = figure.subfigures(2, 1, squeeze=False, height_ratios=sizes)
    _table(parts[0, 0], known)
    _bent_lines(parts[1, 0], bent, lines)
    return figure


@dataclass(frozen=True, kw_only=True)
class MountingEffect:
    """A quantity over a mounting axis, for each θ at one η.

    Attributes
    ----------
    change : DataFrame
        Change from the ideal mounting (%), by the value of the axis and θ.
    slopes : Series
        Slope at the ideal mounting (% per step of `STEPS`), by θ.
    bends : Series
        Largest distance of the change from a line of this slope (%), by θ.
    """

    axis: str
    eta: float
    quantity: str
    change: pd.DataFrame
    slopes: pd.Series
    bends: pd.Series

    @property
    def most_bent(self) -> float:
        """Largest of `bends`, and 0 if none is known."""
        return float(self.bends.max()) if self.bends.notna().any() else 0.0


def _response(points: pd.DataFrame, axis: str, eta: float, quantity: str) -> MountingEffect:
    """Compute the change of a quantity, and its slope at the ideal mounting."""
    table = points.replace(np.inf, np.nan).pivot(index=axis, columns="theta", values=quantity)
    scale = table.loc[0.0].abs()
    if quantity in LOADS:
        ideal = points[points[axis] == 0.0].set_index("theta")
        scale = np.hypot(ideal[LOADS[0]], ideal[LOADS[1]])
    change = 100.0 * (table - table.loc[0.0]) / scale
    step, _ = STEPS[axis]
    over = change.index.to_numpy() / step
    slopes = change.apply(lambda values: _slope(over, values.to_numpy(dtype=float)))
    bends = (change - np.outer(over, slopes)).abs().max()
    return MountingEffect(
        axis=axis, eta=eta, quantity=quantity, change=change, slopes=slopes, bends=bends
    )


def _slope(over: FloatArray, values: FloatArray) -> float:
    """Return the slope at zero, from three known points; NaN if there are fewer or a gap."""
    known = np.flatnonzero(np.isfinite(values))
    at = int(np.argmin(np.abs(over)))
    if len(known) < 3 or at not in known or np.ptp(known) + 1 != len(known):
        return np.nan
    return float(np.gradient(values[known], over[known], edge_order=2)[known == at][0])


def _table(figure: Figure | SubFigure, responses: list[MountingEffect]) -> None:
    """Write the slopes as a table: a row for each axis and η, a column for each quantity and θ."""
    panel = figure.subplots()
    panel.set_axis_off()
    names = list(dict.fromkeys((one.axis, one.eta) for one in responses))
    tapers = list(dict.fromkeys(theta for one in responses for theta in one.slopes.index))
    shown = list(dict.fromkeys(one.quantity for one in responses))
    wide = len(tapers) + 0.6
    panel.set(xlim=(-FIRST_COLUMN, wide * len(shown)), ylim=(len(names) - 0.4, -2.6))
    text: style.Look = {"fontsize": 6.5, "ha": "center", "va": "center"}
    for i, quantity in enumerate(shown):
        panel.text(wide * i + 0.5 * len(tapers), -2.0, SHORT[quantity], **text | {"fontsize": 7.5})
        for j, theta in enumerate(tapers):
            panel.text(wide * i + j + 0.5, -1.05, f"{theta:g}", **text)
    left: style.Look = {"fontsize": 6.5, "ha": "left", "va": "center"}
    panel.text(-FIRST_COLUMN, -2.0, "change / % by", **left)
    panel.text(-0.3, -1.05, r"$\theta =$", **text | {"ha": "right"})
    panel.axhline(-0.55, color=style.INK, linewidth=0.6)
    for line, (axis, eta) in enumerate(names):
        _, words = STEPS[axis]
        panel.text(-FIRST_COLUMN, line, rf"{words}, $\eta = {eta:g}$", **left)
    for one in responses:
        line, column = names.index((one.axis, one.eta)), wide * shown.index(one.quantity)
        for theta, slope in one.slopes.items():
            x = column + tapers.index(theta) + 0.5
            number = "–" if np.isnan(slope) else f"{round(slope, 1) + 0.0:+.1f}"
            panel.text(x, line, number.replace("-", "−").replace("+0.0", "0.0"), **text)
            if one.bends[theta] > BENT:
                panel.add_patch(Rectangle((x - 0.47, line - 0.4), 0.94, 0.8, color=BENDS, zorder=0))
    note = (
        f"shaded: the line leaves its tangent (thin below) by more than {BENT:g} % of the value; "
        r"numbers at lines: $\theta$"
    )
    panel.text(1.0, -0.02, note, transform=panel.transAxes, fontsize=6.5, ha="right", va="top")


def _bent_lines(figure: SubFigure, bent: list[MountingEffect], lines: int) -> None:
    """Draw the responses that bend most, with their tangents at the ideal mounting."""
    grid = figure.subplots(lines, IN_A_ROW, squeeze=False)
    rows = pd.DataFrame({"theta": sorted({theta for one in bent for theta in one.slopes.index})})
    series = Series(rows, "theta")
    for panel, one in zip(grid.flat, bent, strict=False):
        label, unit = AXES[one.axis]
        over = one.change.index.to_numpy()
        for theta, values in one.change.items():
            look: style.Look = {"color": series.color(theta), "linestyle": series.dash(theta)}
            panel.plot(unit * over, values, label=f"{theta:g}", **look)
        low, high = panel.get_ylim()
        for theta, slope in one.slopes.items():
            line: style.Look = {"color": series.color(theta), "linewidth": 0.5, "alpha": 0.6}
            panel.plot(unit * over, slope * over / STEPS[one.axis][0], **line)
        panel.set_ylim(low, high)
        labels.at_ends(panel)
        title = rf"{SHORT[one.quantity]}, $\eta = {one.eta:g}$"
        panel.set_title(title, loc="left", fontsize=7)
        panel.set_xlabel(label, fontsize=7)
        panel.set_ylabel("change / %", fontsize=7)
        panel.tick_params(labelsize=6)
    for panel in grid.flat[len(bent) :]:
        panel.set_visible(False)


@kind("change", columns=(*POINT, *AXES, "mu_lock", "x0_slip", "contact"))
def change(rows: pd.DataFrame) -> Figure:
    """Change of μ_lock and x0_slip (%) due to a deviation of the mounting, over θ and η."""
    rows, _ = _over(rows)
    (deviation,) = set(rows["over"]) - {0.0}
    maps = {}
    for column, symbol in CHANGED.items():
        table = rows.pivot(index="eta", columns=["over", "theta"], values=column)
        maps[f"change of ${symbol}$ / %"] = 100.0 * (table[deviation] / table[0.0] - 1.0)
    figure, panels = _maps(maps, style.TAPER)
    ideal = rows[(rows["over"] == 0.0) & rows["contact"].notna()]
    contacts = ideal.pivot(index="eta", columns="theta", values="contact")
    if ideal["contact"].nunique() > 1:
        onset = panels[-1]
        _border(onset, contacts == "line")
        style.mean(onset, "tip contact on its left, line contact on its right", **BORDER)
        style.legend(figure)
    return figure


def _border(panel: Axes, table: pd.DataFrame) -> None:
    """Draw the border between the cells of a map that are true and those that are not."""
    across, up = style.cells(table.columns), style.cells(table.index)
    is_true = table.to_numpy(dtype=bool)
    for i, j in zip(*np.nonzero(is_true[:, 1:] != is_true[:, :-1]), strict=True):
        panel.plot([across[j + 1]] * 2, up[i : i + 2], **BORDER)
    for i, j in zip(*np.nonzero(is_true[1:] != is_true[:-1]), strict=True):
        panel.plot(across[j : j + 2], [up[i + 1]] * 2, **BORDER)


@kind("versus", columns=(*POINT, *AXES, "mu_lock"))
def versus(rows: pd.DataFrame) -> Figure:
    """Difference of μ_lock from its value at the smallest θ, over η and a mounting parameter."""
    rows, label = _over(rows)
    table = rows.pivot(index="eta", columns=["theta", "over"], values="mu_lock")
    least, *tapers = sorted(set(rows["theta"]))
    lock = CHANGED["mu_lock"]
    names = {theta: f"${lock}({theta:g}) - {lock}({least:g})$" for theta in tapers}
    maps = {name: table[theta] - table[least] for theta, name in names.items()}
    figure, _ = _maps(maps, label, is_one_scale=True)
    return figure


def _maps(
    tables: Mapping[str, pd.DataFrame], label: str, is_one_scale: bool = False
) -> tuple[Figure, list[Axes]]:
    """Draw maps of tables over η and a quantity: red above zero, blue below, grey if unknown."""
    columns = min(len(tables), 3)
    lines = -(-len(tables) // columns)
    figure = style.page(2.6 * lines, style.PAGE)
    grid = figure.subplots(lines, columns, sharey=True, squeeze=False)
    for panel in grid.flat[len(tables) :]:
        panel.set_visible(False)
    panels = list(grid.flat[: len(tables)])
    every = np.concatenate([table.to_numpy(dtype=float).ravel() for table in tables.values()])
    for panel, (name, table) in zip(panels, tables.items(), strict=True):
        low, high = table.min(axis=None), table.max(axis=None)
        bound = _bound(every if is_one_scale else table.to_numpy(dtype=float))
        look: style.Look = {"cmap": "RdBu_r", "vmin": -bound, "vmax": bound, "rasterized": True}
        across, index = style.cells(table.columns), style.cells(table.index)
        mesh = panel.pcolormesh(across, index, table, **look)
        ends = {(True, True): "both", (True, False): "min", (False, True): "max"}
        extend = ends.get((low < -bound, high > bound), "neither")
        bar = figure.colorbar(mesh, ax=panel, label=name, extend=extend)
        bar.ax.tick_params(labelsize=6)
        cells = table.stack()
        for (eta, over), value in cells[cells.abs() > bound].items():
            look = {"ha": "center", "va": "center", "fontsize": 5, "color": "white"}
            panel.text(over, eta, f"{value:+.3g}".replace("-", "−"), **look)
        if min(table.shape) > 1 and low < 0.0 < high:
            panel.contour(table.columns, table.index, table, levels=[0.0], colors="black")
        panel.set_facecolor("#cccccc")
        panel.set_xlabel(label)
    for panel in panels[::columns]:
        panel.set_ylabel(HEIGHT)
    return figure, panels


def _bound(values: FloatArray) -> float:
    """Return the end of a scale: the largest value, or less if only a few cells are beyond it."""
    sizes = np.abs(values[np.isfinite(values)])
    if not sizes.size or sizes.max() == 0.0:
        return 1.0
    usual = sizes[sizes <= CLIPPED * np.quantile(sizes, USUAL)]
    return float(usual.max()) if usual.any() else float(sizes.max())

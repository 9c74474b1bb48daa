"""The figures, drawn from tables alone.

Each kind of figure is a function of a table and of which of its rows to show; `draw` picks it by
name. Lengths are in units of the rod's length L.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
import pyarrow as pa
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from vibrissa import tables
from vibrissa.arrays import FloatArray
from vibrissa.files import write_atomically

WIDTH = 6.3
RESOLUTION = 200
# Room beside the shapes of single states, for what is known of them (L).
ROOM_FOR_NUMBERS = 0.6
# Points next to the lock to which its law is fitted, and how far it is drawn, relative to mu_lock.
FITTED_POINTS = 16
NEAR_LOCK = 0.1
LOCKED = "the tip locks, shown as far as it sticks"
# Colours that readers with any colour vision tell apart (Okabe and Ito), and the paper's markers.
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
MARKERS = ("s", "D", "^", "o", "v", "P")
SURFACE, SHAPE, START, END = "#555555", "#6d9dc5", "#0072b2", "#d55e00"

# What is needed of a table that may be very long.
_POINT = ("theta", "mu0", "eta", "dx0", "status", "message")
COLUMNS = {
    "taper": (*_POINT, "x0_slip", "x0_max", "penetrates"),
    "friction": (*_POINT, "x0_slip", "x0_max", "n_steps", "mu_lock"),
    "locking": ("theta", "eta", "status", "message", "mu_lock"),
    "regimes": (*_POINT, "contact", "end", "mu_lock"),
    "law": (*_POINT, "x0_slip", "mu_lock", "x0_lock"),
}

STYLE: Any = {
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    # Identical files from identical tables
    "svg.hashsalt": "vibrissa",
}


def draw(kind: str, table: pa.Table | tables.Stored, selection: Mapping[str, Any]) -> Figure:
    """Draw a figure.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    table : pyarrow.Table or Stored
        Table that the kind is drawn from (`vibrissa.tables`); of one in a file no more is read than
        is shown.
    selection : mapping
        Which rows: ``grid``, ``scan``, ``state`` or ``comparison``, and values of the axes that are
        fixed.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If the selection leaves nothing to draw, or the kind is unknown.
    """
    if kind not in KINDS:
        raise ValueError(f"unknown kind of figure {kind!r}; allowed: {', '.join(KINDS)}")
    rows = tables.frame(table, COLUMNS.get(kind, table.schema.names), selection)
    if rows.empty:
        raise ValueError(f"no rows to draw for {kind} figure with {dict(selection)}")
    with matplotlib.rc_context(STYLE):
        if "status" in rows and rows["status"].isin(["failed", "out_of_reach"]).all():
            return _failure(rows)
        return KINDS[kind](rows)


def save(figure: Figure, paths: Sequence[str | Path]) -> None:
    """Write a figure in the formats of the paths' endings, each file whole or not at all.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    paths : sequence of path
        Ending in ``.pdf``, ``.svg`` or ``.png``.
    """
    FigureCanvasAgg(figure)
    dateless: dict[str, dict[str, str | None]] = {
        ".pdf": {"CreationDate": None},
        ".svg": {"Date": None},
    }
    with matplotlib.rc_context(STYLE):
        for path in map(Path, paths):
            with write_atomically(path) as temporary:
                figure.savefig(
                    temporary,
                    format=path.suffix[1:],
                    dpi=RESOLUTION,
                    metadata=dateless.get(path.suffix),
                )


def _axes(height: float) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplots()


def _failure(rows: pd.DataFrame) -> Figure:
    """Say that there is nothing to show: the study goes on without it."""
    figure, axes = _axes(2.0)
    axes.set_axis_off()
    reason = rows["message"].iloc[0] if "message" in rows else "the tables and logs say why"
    status = rows["status"].iloc[0].replace("_", " ")
    axes.text(0.5, 0.5, f"{status}: {reason}", ha="center", va="center", wrap=True)
    return figure


def _taper(rows: pd.DataFrame) -> Figure:
    """x0,max over θ for each μ0: the step grid's marks and the exact onset (paper Figure 6)."""
    figure, axes = _axes(4.2)
    for i, (mu0, series) in enumerate(rows.sort_values("theta").groupby("mu0")):
        color = COLORS[i % len(COLORS)]
        axes.plot(series["theta"], series["x0_slip"], color=color, linewidth=0.8)
        style: dict[str, Any] = {"linestyle": "none", "marker": MARKERS[i % len(MARKERS)]}
        label = rf"$\mu_0 = {mu0:g}$"
        passes = series["penetrates"].fillna(False).astype(bool)
        inside, through = series[~passes], series[passes]
        axes.plot(
            inside["theta"], inside["x0_max"], markersize=5, color=color, label=label, **style
        )
        style |= {"markersize": 5, "markerfacecolor": "white"}
        axes.plot(through["theta"], through["x0_max"], color=color, **style)
    axes.plot([], [], color="black", linewidth=0.8, label="exact onset of slip")
    if rows["penetrates"].fillna(False).any():
        label = "hollow: the rod passes through the surface"
        axes.plot([], [], "o", color="black", markerfacecolor="white", label=label)
    first = rows.iloc[0]
    marks = rf"marks: last state of stiction, $\Delta x_0 = {first['dx0']:g}$"
    axes.set_title(rf"$\eta = {first['eta']:g}$; {marks}", fontsize=10)
    axes.set_xlabel(r"taper factor $\theta = d_0/d_1$")
    axes.set_ylabel(r"footpoint displacement $x_{0,\mathrm{max}}$ / $L$")
    axes.set_ylim(bottom=0)
    axes.margins(x=0.03)
    axes.legend()
    return figure


def _friction(rows: pd.DataFrame) -> Figure:
    """x0,max over μ0: levels of the step grid, exact onset and locking (paper Figure 7)."""
    figure, axes = _axes(4.6)
    rows = rows.sort_values("mu0")
    slips = rows[rows["status"] == "slip"]
    mu_lock = rows["mu_lock"].iloc[0]

    def series(axes: Axes, size: float) -> None:
        axes.plot(
            slips["mu0"],
            slips["x0_slip"],
            color=COLORS[1],
            linewidth=0.9,
            label="exact onset of slip",
        )
        axes.plot(
            slips["mu0"],
            slips["x0_max"],
            linestyle="none",
            marker="o",
            markersize=size,
            color=COLORS[0],
            label=rf"last state of stiction, $\Delta x_0 = {rows['dx0'].iloc[0]:g}$",
        )

    series(axes, 2.2)
    if rows["mu0"].iloc[-1] > mu_lock:
        axes.axvspan(mu_lock, rows["mu0"].iloc[-1], color="#eeeeee", linewidth=0)
    axes.axvline(mu_lock, color=SURFACE, linewidth=0.9, linestyle="--")
    axes.annotate(
        rf"the tip locks above $\mu_\mathrm{{lock}} = {mu_lock:.4f}$",
        (mu_lock, 0.03),
        xycoords=("data", "axes fraction"),
        xytext=(4, 0),
        textcoords="offset points",
        rotation=90,
        ha="left",
        va="bottom",
        color=SURFACE,
    )
    first = rows.iloc[0]
    axes.set_title(rf"$\theta = {first['theta']:g}$, $\eta = {first['eta']:g}$", fontsize=10)
    axes.set_xlabel(r"coefficient of static friction $\mu_0$")
    axes.set_ylabel(r"footpoint displacement $x_{0,\mathrm{max}}$ / $L$")
    axes.set_ylim(bottom=0)
    axes.margins(x=0.03)
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 1.0))
    _levels_inset(axes, slips, series)
    return figure


def _levels_inset(axes: Axes, slips: pd.DataFrame, series: Callable[[Axes, float], None]) -> None:
    """Enlarge the first levels of the step grid where they are too many to be told apart."""
    levels = np.unique(slips["n_steps"])
    if len(levels) < 20:
        return
    window = slips[slips["n_steps"] <= levels[6]]
    inset = axes.inset_axes((0.09, 0.40, 0.42, 0.38))
    series(inset, 3.5)
    step = slips["dx0"].iloc[0]
    inset.set_xlim(window["mu0"].min() - 0.002, window["mu0"].max() + 0.002)
    inset.set_ylim((levels[0] - 0.6) * step, (levels[6] + 1.4) * step)
    inset.set_yticks(levels[:7] * step)
    inset.yaxis.grid(True, linewidth=0.4, color="#cccccc")
    inset.tick_params(labelsize=7)
    for spine in inset.spines.values():
        spine.set_visible(True)
        spine.set_color("#999999")
    inset.set_title("levels of the step grid", fontsize=8)
    axes.indicate_inset_zoom(inset, edgecolor="#999999")


def _locking(rows: pd.DataFrame) -> Figure:
    """μ_lock over θ for each η."""
    figure, axes = _axes(4.2)
    curves = rows.drop_duplicates(["theta", "eta"]).sort_values("theta")
    for i, (eta, series) in enumerate(curves.groupby("eta")):
        color = COLORS[i % len(COLORS)]
        # Infinite where the tip lifts off instead: no point to draw.
        finite = series["mu_lock"].where(np.isfinite(series["mu_lock"].astype(float)))
        axes.plot(series["theta"], finite, color=color, linewidth=1.2, label=rf"$\eta = {eta:g}$")
    axes.set_xlabel(r"taper factor $\theta = d_0/d_1$")
    axes.set_ylabel(r"locking friction $\mu_\mathrm{lock}$")
    axes.set_ylim(bottom=0)
    axes.margins(x=0.03)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def _regimes(rows: pd.DataFrame) -> Figure:
    """Map over θ and μ0, a panel for each η: slips in point or in line contact, or locks."""
    heights = sorted(rows["eta"].unique())
    figure = Figure(figsize=(WIDTH, 0.6 + 2.6 * len(heights) / 2), layout="constrained")
    panels = figure.subplots(-(-len(heights) // 2), 2, sharex=True, sharey=True, squeeze=False)
    names = {
        "slips in point contact": (rows["status"] == "slip") & (rows["contact"] == "point"),
        "slips in line contact": (rows["status"] == "slip") & (rows["contact"] == "line"),
        "locks, then slips back": rows["end"] == "slips_back",
        "locks, then snaps through": rows["end"] == "snaps",
        "locks, then out of reach": rows["end"] == "out_of_reach",
        "locks, not followed further": rows["end"] == "not_followed",
        "no result": ~rows["status"].isin(["slip", "lock"]),
    }
    colors = ListedColormap(
        ["#0072b2", "#009e73", "#d55e00", "#e69f00", "#cc79a7", "#f0e442", "#ffffff"]
    )
    regime = np.select(list(names.values()), list(range(len(names))))
    for axes, eta in zip(panels.flat, heights, strict=False):
        chosen = (rows["eta"] == eta).to_numpy()
        # One step size stands for all: the regime does not depend on it.
        table = rows[chosen].assign(regime=regime[chosen]).drop_duplicates(["theta", "mu0"])
        field = table.pivot(index="mu0", columns="theta", values="regime")
        axes.pcolormesh(
            *(field.columns, field.index, field),
            cmap=colors,
            vmin=0,
            vmax=len(names) - 1,
            shading="nearest",
        )
        locks = table.drop_duplicates("theta").sort_values("theta")
        axes.plot(locks["theta"], locks["mu_lock"], color="black", linewidth=1.0)
        axes.set_ylim(field.index.min(), field.index.max())
        axes.set_title(rf"$\eta = {eta:g}$", fontsize=10)
    for axes in panels.flat[len(heights) :]:
        axes.set_visible(False)
    shown = [(i, name) for i, name in enumerate(names) if (regime == i).any()]
    patches = [Patch(facecolor=colors(i), edgecolor=SURFACE, label=name) for i, name in shown]
    figure.legend(handles=patches, loc="outside lower center", ncols=2, fontsize=9)
    for axes in panels[-1]:
        axes.set_xlabel(r"taper factor $\theta = d_0/d_1$")
    for axes in panels[:, 0]:
        axes.set_ylabel(r"friction coefficient $\mu_0$")
    return figure


def _scan(rows: pd.DataFrame) -> Figure:
    """Shapes at every footpoint position of a scan (paper Figures 4 and 5)."""
    starts = rows[rows["x0"] == 0]
    figure, axes = _shape_axes(rows)
    _shapes(axes, rows, color=SHAPE, linewidth=0.2)
    _shapes(axes, starts, color=START, linewidth=0.9)
    axes.plot([], [], color=START, linewidth=0.9, label=r"$\alpha = 0$: a period begins")
    axes.plot([], [], color=SHAPE, linewidth=0.8, label="sticking")
    _clamps(axes, rows, 1.5)
    cycles = int(rows["cycle"].max())
    what = f"{cycles} stick-slip cycle{'s' if cycles > 1 else ''}"
    _title(axes, rows, LOCKED if rows["status"].iloc[0] == "lock" else what)
    return figure


def _period(rows: pd.DataFrame) -> Figure:
    """Shapes of the first period of sticking of a scan (paper Figure 3)."""
    rows = rows[(rows["cycle"] == 1) & (rows["phase"] == "stick")]
    locks = rows["status"].iloc[0] == "lock"
    last = "last step of sticking" if locks else "last state of stiction"
    figure, axes = _shape_axes(rows)
    _shapes(axes, rows, color=SHAPE, linewidth=0.3)
    _shapes(axes, rows.iloc[[0]], color=START, linewidth=1.8)
    _shapes(axes, rows.iloc[[-1]], color=END, linewidth=1.8)
    axes.plot([], [], color=START, linewidth=1.8, label=r"first state, $\alpha = 0$")
    axes.plot([], [], color=END, linewidth=1.8, label=last)
    _clamps(axes, rows, 2.5)
    travel = rows["footpoint"].iloc[-1]
    what = rf"one period of sticking, $x_{{0,\mathrm{{max}}}} = {travel:g}$"
    _title(axes, rows, LOCKED if locks else what)
    return figure


def _state(rows: pd.DataFrame) -> Figure:
    """Shapes of single equilibria (paper Figure 8)."""
    rows = rows[rows["status"] == "solved"]
    figure, axes = _shape_axes(rows, beside=ROOM_FOR_NUMBERS)
    for i, (_, row) in enumerate(rows.iterrows()):
        color = (START, END, COLORS[2], COLORS[3])[i % 4]
        _one_state(axes, row, color, below=i)
    top = max(max(y) for y in rows["shape_y"])
    axes.plot(0, 0, "s", color="black", markersize=7)
    axes.set_ylim(top=max(top, rows["eta"].iloc[0]) + 0.12)
    left, right = min(map(min, rows["shape_x"])), max(map(max, rows["shape_x"]))
    axes.set_xlim(left - 0.08, right + 0.04 + ROOM_FOR_NUMBERS)
    row = rows.iloc[0]
    where = rf"$(x_1, y_1) = ({row['x1']:g}, {row['eta']:g})$"
    axes.set_title(rf"$\theta = {row['theta']:g}$, {where}", fontsize=10)
    return figure


def _one_state(axes: Axes, row: pd.Series, color: str, below: int) -> None:
    """Draw a shape with its force, slope and contact, and where it passes through the surface."""
    axes.plot(row["shape_x"], row["shape_y"], color=color, linewidth=1.8, solid_capstyle="round")
    # What lies beyond the contact point lies straight.
    axes.plot(row["x1"] - (1.0 - row["s_c"]), row["eta"], "o", color=color, markersize=5, zorder=3)
    axes.text(
        0.98,
        0.60 - 0.26 * below,
        f"{row['contact']} contact\n"
        rf"$f = {row['f']:.3f}$, $\tan\alpha = {np.tan(row['alpha']):.3f}$"
        "\n"
        rf"$\varphi_1 = {row['phi1']:.3f}$ rad, $s_c = {row['s_c']:.3f}$",
        transform=axes.transAxes,
        ha="right",
        va="top",
        color=color,
        fontsize=9,
    )
    top = int(np.argmax(row["shape_y"]))
    if row["penetrates"]:
        axes.annotate(
            f"passes through the surface\n(up to y = {row['shape_y'][top]:.4f})",
            (row["shape_x"][top], row["shape_y"][top]),
            xytext=(14, 14),
            textcoords="offset points",
            color=color,
            arrowprops={"arrowstyle": "-", "color": SURFACE},
        )


def _law(rows: pd.DataFrame) -> Figure:
    """x0_slip over μ0 up to the lock for each θ, and the power law near it."""
    figure = Figure(figsize=(WIDTH, 3.6), layout="constrained")
    axes, near = figure.subplots(1, 2)
    slips = rows[rows["status"] == "slip"].sort_values("mu0")
    for i, (theta, series) in enumerate(slips.groupby("theta")):
        color = COLORS[i % len(COLORS)]
        gap, distance = series["mu_lock"] - series["mu0"], series["x0_lock"] - series["x0_slip"]
        exponent, law = _power_law(gap.to_numpy(float), distance.to_numpy(float))
        label = rf"$\theta = {theta:g}$"
        axes.plot(series["mu0"], series["x0_slip"], ".", markersize=2, color=color, label=label)
        axes.plot(series["mu_lock"].iloc[0], series["x0_lock"].iloc[0], "o", color=color)
        close = gap < NEAR_LOCK * series["mu_lock"]
        axes.plot(
            series["mu0"][close],
            (series["x0_lock"] - law(gap.to_numpy(float)))[close],
            color="black",
            linewidth=0.8,
        )
        near.loglog(gap, distance, ".", markersize=3, color=color)
        line = np.geomspace(gap.min(), NEAR_LOCK * series["mu_lock"].iloc[0], 50)
        near.loglog(
            line,
            law(line),
            color=color,
            linewidth=0.8,
            label=rf"$\theta = {theta:g}$: exponent {exponent:.3f}",
        )
    axes.plot([], [], color="black", linewidth=0.8, label="law fitted near the lock")
    axes.set_xlabel(r"coefficient of static friction $\mu_0$")
    axes.set_ylabel(r"onset of slip $x_{0,\mathrm{slip}}$ / $L$")
    axes.set_title(rf"$\eta = {rows['eta'].iloc[0]:g}$", fontsize=10)
    axes.legend(fontsize=8)
    near.set_xlabel(r"$\mu_\mathrm{lock} - \mu_0$")
    near.set_ylabel(r"$x_{0,\mathrm{lock}} - x_{0,\mathrm{slip}}$")
    near.set_title("distance from the lock", fontsize=10)
    near.legend(fontsize=8, loc="upper left")
    return figure


def _power_law(
    gap: FloatArray, distance: FloatArray
) -> tuple[float, Callable[[FloatArray], FloatArray]]:
    """Exponent p of distance ∝ gap^p·(1 + a·√gap + ...), and this law, fitted near the lock.

    The second factor is the next term of the expansion; without it the exponent would depend on
    how far from the lock the points lie.
    """
    nearest = np.argsort(gap)[:FITTED_POINTS]
    known = nearest[(gap[nearest] > 0.0) & (distance[nearest] > 0.0)]

    def terms(gap: FloatArray) -> FloatArray:
        return np.stack([np.ones_like(gap), np.log(gap), np.log1p(np.sqrt(gap))], axis=-1)

    fitted, *_ = np.linalg.lstsq(terms(gap[known]), np.log(distance[known]), rcond=None)
    return float(fitted[1]), lambda gap: np.exp(terms(gap) @ fitted)


def _models(rows: pd.DataFrame) -> Figure:
    """Error of the point model's onset, and its locking friction, over θ."""
    figure = Figure(figsize=(WIDTH, 3.8), layout="constrained")
    axes, locks = figure.subplots(1, 2)
    rows = rows.sort_values("theta")
    for i, (mu0, series) in enumerate(rows.groupby("mu0")):
        error = series["x0_slip_point"] / series["x0_slip_line"] - 1.0
        wrong = error.where(series["penetrates"])
        color = COLORS[i % len(COLORS)]
        axes.plot(series["theta"], 100.0 * error, color=color, linewidth=0.7)
        axes.plot(
            *(series["theta"], 100.0 * wrong),
            *("o",),
            markersize=2.5,
            color=color,
            label=rf"$\mu_0 = {mu0:g}$",
        )
    axes.set_ylabel(r"error of $x_{0,\mathrm{slip}}$ in point contact / %")
    axes.set_title(rf"$\eta = {rows['eta'].iloc[0]:g}$; marks: penetrates", fontsize=10)
    axes.legend(fontsize=8)
    curves = rows.drop_duplicates("theta")
    for model, color in (("point", COLORS[0]), ("line", COLORS[1])):
        lock = curves[f"mu_lock_{model}"].astype(float)
        lock = lock.where(np.isfinite(lock))
        locks.plot(curves["theta"], lock, color=color, label=f"{model} contact")
    locks.set_ylabel(r"locking friction $\mu_\mathrm{lock}$")
    locks.set_ylim(bottom=0)
    locks.legend(fontsize=8)
    for panel in (axes, locks):
        panel.set_xlabel(r"taper factor $\theta = d_0/d_1$")
    return figure


def _signals(rows: pd.DataFrame) -> Figure:
    """Inclination, clamp reactions and stability over the clamp's way."""
    figure = Figure(figsize=(WIDTH, 6.0), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    rows = rows.sort_values("footpoint")
    x = rows["footpoint"]
    friction = rows["mu0"].iloc[0]
    panels[0].plot(x, np.tan(rows["alpha"]), color=COLORS[0])
    for bound in (-friction, friction):
        panels[0].axhline(bound, color=SURFACE, linewidth=0.8, linestyle="--")
    panels[0].set_ylabel(r"$\tan\alpha$, bounds $\pm\mu_0$")
    for name, label, color in (
        ("reaction_fx", "$F_x$", COLORS[0]),
        ("reaction_fy", "$F_y$", COLORS[1]),
        ("reaction_m", "$M$", COLORS[2]),
    ):
        panels[1].plot(x, rows[name], color=color, label=label)
    panels[1].set_ylabel("clamp reactions")
    panels[1].legend(fontsize=9, ncols=3)
    panels[2].plot(x, rows["stability"].astype(float), color=COLORS[3])
    panels[2].set_ylabel("margin of stability")
    panels[2].set_ylim(bottom=min(0.0, rows["stability"].astype(float).min()))
    panels[2].set_xlabel("footpoint position / $L$")
    cycles = int(rows["cycle"].max())
    what = f"{cycles} stick-slip cycle{'s' if cycles > 1 else ''}"
    _title(panels[0], rows, LOCKED if rows["status"].iloc[0] == "lock" else what)
    return figure


KINDS: dict[str, Callable[[pd.DataFrame], Figure]] = {
    "taper": _taper,
    "friction": _friction,
    "locking": _locking,
    "regimes": _regimes,
    "law": _law,
    "scan": _scan,
    "period": _period,
    "signals": _signals,
    "state": _state,
    "models": _models,
}


def _shape_axes(rows: pd.DataFrame, beside: float = 0.0) -> tuple[Figure, Axes]:
    """Axes of equal scale with the surface, on a page of the shapes' proportions.

    `beside` is how much of the surface is to be seen beyond them (L).
    """
    x = np.concatenate(list(rows["shape_x"]))
    y = np.concatenate(list(rows["shape_y"]))
    width = x.max() - x.min() + 0.1 + beside
    height = max(y.max(), rows["eta"].iloc[0]) + 0.1
    figure, axes = _axes(min(6.0, max(3.2, 5.6 * height / width)) + 0.9)
    axes.set_aspect("equal")
    eta = rows["eta"].iloc[0]
    axes.axhline(eta, color=SURFACE, linewidth=1.2)
    axes.axhspan(eta, eta + 0.03, facecolor="none", edgecolor="#aaaaaa", hatch="////", linewidth=0)
    axes.set_xlim(x.min() - 0.05, x.max() + 0.05)
    axes.set_ylim(-0.05, height)
    axes.set_xlabel(r"$x$ / $L$")
    axes.set_ylabel(r"$y$ / $L$")
    return figure, axes


def _shapes(axes: Axes, rows: pd.DataFrame, **style: Any) -> None:
    for x, y in zip(rows["shape_x"], rows["shape_y"], strict=True):
        axes.plot(x, y, solid_capstyle="round", **style)


def _clamps(axes: Axes, rows: pd.DataFrame, size: float) -> None:
    """Mark the positions of the clamp, and put the legend below."""
    step = rows["dx0"].iloc[0]
    style: dict[str, Any] = {"linestyle": "none", "marker": ".", "color": "black"}
    axes.plot(rows["footpoint"], 0 * rows["footpoint"], markersize=size, **style)
    axes.plot([], [], markersize=5, label=rf"clamp, $\Delta x_0 = {step:g}$", **style)
    axes.figure.legend(loc="outside lower center", ncols=3, fontsize=9)


def _title(axes: Axes, rows: pd.DataFrame, what: str) -> None:
    row = rows.iloc[0]
    axes.set_title(
        rf"$\theta = {row['theta']:g}$, $\mu_0 = {row['mu0']:g}$, $\eta = {row['eta']:g}$: {what}",
        fontsize=10,
    )

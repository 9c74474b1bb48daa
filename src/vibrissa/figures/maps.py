"""Figures of a grid over any of its axes: x0,max along one axis, or a column over two."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from vibrissa.figures import style
from vibrissa.figures.kinds import POINT, kind
from vibrissa.figures.series import QUANTITIES, SYMBOLS, Series
from vibrissa.study.axes import AXES
from vibrissa.tables.frames import spell_unit
from vibrissa.tables.schemas import NUMBER, STICTION, UNIT

# Label of each axis.
LABELS = {
    "theta": style.TAPER,
    "mu0": style.FRICTION,
    "eta": r"clamp–surface distance $\eta$ / $L$",
    "dx0": r"step of the clamp $\Delta x_0$ / $L$",
    "clamp_angle": r"inclination of the clamp $\beta$ / rad",
    "clamp_compliance": r"compliance of the clamp $c$ / $L/(E I_0)$",
    "curvature": r"natural curvature $\kappa_0 L$",
    "stiffening": "stiffening $c_1$",
    "bore": "bore $b$ / $d_0$",
    "stage_angle": r"angle of the stage $\delta$ / rad",
    "mean": r"mean of $\mu_0$",
    "deviation": r"standard deviation of $\mu_0$",
    "correlation": r"correlation length of $\mu_0$ / $L$",
    "seed": "seed of the surface",
    "wave_amplitude": "amplitude of the wave / $L$",
    "wave_wavelength": "wavelength / $L$",
    "wave_phase": "phase of the wave / rad",
    "grooves_width": "width of the grooves / $L$",
    "grooves_depth": "depth of the grooves / $L$",
    "grooves_pitch": "pitch of the grooves / $L$",
    "grooves_wall": "inclination of the walls / rad",
    "rough_deviation": "standard deviation $R_q$ of the heights / $L$",
    "rough_correlation": "correlation length of the heights / $L$",
    "rough_seed": "seed of the heights",
    "lay": "angle to the lay / rad",
    "tip_radius": "radius of the tip / $L$",
    "kinetic_ratio": r"$\mu_k/\mu_0$",
    "damping": r"damping ratio $\zeta$",
    "law": "slip law",
    "surface": "surface",
    "transducer": "transducer",
    "read_by": "method",
    "readings": "readings",
}
COLUMNS = tuple(field.name for field in STICTION if field.type == NUMBER)


@kind("onset", columns=tuple({*POINT, *AXES, "x0_slip", "x0_max"}), keys=("over", "by"))
def onset(rows: pd.DataFrame, over: str, by: str) -> Figure:
    """x0,max, a multiple of Δx0, and the exact onset over an axis, a series for each value."""
    series = Series(rows, by)
    figure, panel = style.axes(3.0)
    series.lines(panel, rows, over, "x0_slip", label=None, linewidth=0.6)
    series.lines(panel, rows, over, "x0_max", size=3.5)
    style.mean(panel, "last sticking state on the step grid", marker=".", color="black", ls="none")
    style.mean(panel, "exact onset of slip", color="black", linewidth=0.6)
    series.gaps(panel, rows, over)
    panel.set(xlabel=LABELS[over], ylabel=style.DISPLACEMENT)
    style.from_zero(panel)
    series.explain(panel)
    return figure


@kind("map", columns=tuple({*POINT, *AXES, *COLUMNS}), keys=("over", "by", "value"))
def over_two(rows: pd.DataFrame, over: str, by: str, value: str = "x0_slip") -> Figure:
    """Draw a column over two axes; grey where it has no value."""
    table = rows.replace(np.inf, np.nan).pivot(index=by, columns=over, values=value)
    figure, panel = style.axes(3.0)
    across, upward = style.cells(table.columns), style.cells(table.index)
    drawn = panel.pcolormesh(across, upward, table, cmap="viridis", rasterized=True)
    unit = spell_unit(STICTION.field(value).metadata[UNIT].decode())
    plain = value if unit == "1" else f"{value} / {unit}"
    figure.colorbar(drawn, ax=panel, label=QUANTITIES.get(value, plain))
    panel.set_facecolor("#cccccc")
    panel.set(xlabel=LABELS[over], ylabel=LABELS[by])
    if table.isna().any(axis=None):
        style.mean(panel, "no value", marker="s", color="#cccccc", linestyle="none")
        style.legend(figure)
    return figure


def symbol(axis: str) -> str:
    """Return the symbol of an axis in mathematical notation."""
    return SYMBOLS.get(axis, rf"\mathrm{{{axis}}}".replace("_", r"\ "))

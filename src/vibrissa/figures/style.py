"""Common style of all figures: width, type, colours, legend, files."""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import matplotlib
import numpy as np
import pandas as pd
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure, SubFigure

from vibrissa import __version__
from vibrissa.figures import parts
from vibrissa.files import write_atomically
from vibrissa.numerics.arrays import FloatArray
from vibrissa.provenance import commit
from vibrissa.study.figures import PARTS

# Keyword arguments of matplotlib, such as colour and line width.
Look: TypeAlias = dict[str, Any]
# Widths of a figure (inch): one column of a journal, and the whole page.
COLUMN, PAGE = 3.5, 7.2
# Resolution of a PNG (dots per inch).
DPI = 300
# A tenth larger than by default, in three quarters of the time.
PACKED = {"compress_level": 3}
# Colours that readers with any colour vision tell apart (Okabe and Ito), and the paper's markers.
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
MARKERS = ("s", "D", "^", "o", "v", "P")
SURFACE, SHAPE, START, END = "#555555", "#cddae4", "#00487a", "#d55e00"
# Forces and loads, and all else that is not data.
LOAD, INK = "#a3263f", "#222222"
# Mark of lines that have their names beside them.
NAMED = "named at the line"
# What no real rod does.
WARNING = "#d55e00"
# Dashes of lines, so that they differ without colours, too.
DASHES = ("-", (0, (5, 1.5)), (0, (1, 1.2)), (0, (6, 1.2, 1, 1.2)), (0, (10, 2)), (0, (2.5, 1.2)))
# Marker and legend entry of points without an onset of slip, by status.
WITHOUT_ONSET = {"lock": ("|", "locks"), "out_of_reach": ("_", "out of reach")} | {
    "failed": ("x", "failed")
}
HOLLOW: Look = {"marker": "o", "color": "black", "markerfacecolor": "white", "linestyle": "none"}
THIN: Look = {"color": "black", "linewidth": 0.8}

# Lines of natural frequencies.
FREQUENCY_LOOKS = {"first": "-", "second": "--"}
FREQUENCY = r"natural frequency / $\sqrt{E I_0 / (\rho A_0 L^4)}$"
TAPER = r"taper factor $\theta$"
FRICTION = r"coefficient of static friction $\mu_0$"
LOCKING_FRICTION = r"critical friction coefficient $\mu_\mathrm{lock}$"
DISPLACEMENT = r"clamp displacement $x_{0,\mathrm{max}}$ / $L$"

SETTINGS: Any = {
    # Journals require TrueType fonts.
    "pdf.fonttype": 42,
    # Outlines, as a browser may lack the typeface.
    "svg.fonttype": "path",
    "font.family": ["STIXGeneral", "DejaVu Serif"],
    "mathtext.fontset": "stix",
    "font.size": 8,
    "legend.fontsize": 7,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "axes.prop_cycle": cycler(color=COLORS),
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.0,
    "lines.markersize": 3.5,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.columnspacing": 1.2,
    "figure.figsize": (COLUMN, 2.6),
    "figure.constrained_layout.use": True,
    # Where titles are if no ticks are above them, for which matplotlib looks many times.
    "axes.titley": 1.0,
    "savefig.dpi": DPI,
    # Identical files from identical tables
    "svg.hashsalt": "vibrissa",
}
# Names under which each format stores the title, the study and the program of a figure.
_METADATA = {
    ".pdf": ("Title", "Subject", "Creator"),
    ".svg": ("Title", "Description", "Creator"),
    ".png": ("Title", "Description", "Software"),
}
# Without a date, the same tables give the same files.
_DATELESS: dict[str, dict[str, None]] = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}


def applied() -> AbstractContextManager[None]:
    """Return a context with matplotlib's settings for all figures."""
    return matplotlib.rc_context(SETTINGS)


def page(height: float, width: float = COLUMN) -> Figure:
    """Make an empty figure; sizes in inch."""
    # With the resolution of the PNG, which is then drawn with texts that the layout has measured.
    return Figure(figsize=(width, height), dpi=DPI, layout="constrained")


def axes(height: float) -> tuple[Figure, Axes]:
    """Make a figure of one column with one panel; the height in inch."""
    figure = page(height)
    return figure, figure.subplots()


def message(text: str) -> Figure:
    """Make a figure without data that shows a text."""
    figure, panel = axes(1.2)
    panel.set_axis_off()
    # A text from elsewhere may have dollar signs, which would make it a formula.
    look: Look = {"ha": "center", "va": "center", "wrap": True, "parse_math": False}
    panel.text(0.5, 0.5, text, transform=panel.transAxes, **look)
    return figure


def legend(figure: Figure | SubFigure, beside: bool = False, **look: Any) -> None:
    """Put one legend of all panels below or beside them, where it covers no data.

    Lines that have their names beside them are left out.
    """
    shown = {
        label: handle
        for panel in figure.axes
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)
        if handle.get_gid() != NAMED
    }
    width = figure.bbox.width / figure.dpi
    if shown:
        place = "outside right center" if beside else "outside lower center"
        columns = 1 if beside else 2 if width < PAGE else 4
        look = {"loc": place, "ncols": columns, **look}
        figure.legend(handles=list(shown.values()), labels=list(shown), **look)


def mean(panel: Axes, label: str, **look: Any) -> None:
    """Explain a marker or a line in the legend, without drawing it in the panel."""
    panel.plot([], [], label=label, **look)


def no_result(panel: Axes, name: str) -> None:
    """Name in the legend what has no result."""
    mean(panel, f"no result: {name}", marker="x", color="black", linestyle="none")


def from_zero(panel: Axes) -> None:
    """Let the ordinate begin at zero, with room for the mark of a single point."""
    panel.update_datalim([(0.0, 0.0)], updatex=False)
    panel.autoscale_view()
    panel.set_ylim(bottom=0.0)


def cells(centres: pd.Index) -> FloatArray:
    """Return the bounds of cells around the values of an axis, from its first to its last value."""
    values = np.asarray(centres, dtype=float)
    if len(values) == 1:
        half = 0.1 * (abs(values[0]) or 1.0)
        return np.array([values[0] - half, values[0] + half])
    return np.array([values[0], *(0.5 * (values[1:] + values[:-1])), values[-1]])


def alone(values: Sequence[float] | pd.Series) -> Look:
    """Return marks for those points of a line that have no neighbour, as no line shows them."""
    known = np.pad(np.isfinite(np.asarray(values, dtype=float)), 1)
    single = known[1:-1] & ~known[:-2] & ~known[2:]
    return {"marker": "o", "markevery": single.tolist()} if single.any() else {"marker": ""}


@cache
def _program() -> str:
    """Describe the running program once for all figures: git is asked for its commit."""
    return f"Vibrissa {__version__}, commit {commit()}"


def save(figure: Figure, paths: Sequence[str | Path], title: str = "", study: str = "") -> None:
    """Write a figure as ``.pdf``, ``.svg`` or ``.png``, each file atomically.

    The files store the title, the name of the study, and version and commit of the program.
    """
    FigureCanvasAgg(figure)
    about = title or "figure", f"study {study}" if study else "no study", _program()
    with applied():
        # Laid out once for all formats, which measure text differently.
        engine = figure.get_layout_engine()
        if engine and figure.axes:
            engine.execute(figure)
    # None means the engine of the settings, and each `savefig` sets it again.
    with applied(), matplotlib.rc_context({"figure.constrained_layout.use": False}):
        # With "none" in place of None every format would be drawn twice.
        figure.set_layout_engine(None)
        for path in map(Path, paths):
            names = _METADATA[path.suffix]
            metadata = dict(zip(names, about, strict=True)) | _DATELESS.get(path.suffix, {})
            options: Look = {"format": path.suffix[1:], "metadata": metadata}
            if path.suffix == ".png":
                metadata[PARTS] = parts.parts_of(figure)
                options["pil_kwargs"] = PACKED
            with write_atomically(path) as temporary:
                figure.savefig(temporary, **options)

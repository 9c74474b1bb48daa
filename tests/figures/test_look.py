"""What each kind of figure looks like, as a text that is stored.

After a change that was meant, `pytest tests/figures/test_look.py --snapshot-update` stores it anew;
look at the pictures, and at the difference of the texts, before you commit it.
"""

import numpy as np
import pytest
from matplotlib.artist import Artist
from matplotlib.colors import to_hex

from figure_rows import ROWS, drawn


def short(values):
    """Number, mean and last of some values, to four digits."""
    some = np.ma.masked_invalid(np.asarray(values, dtype=float).ravel()).compressed()
    some = some.round(12) + 0.0  # no rounding errors, no −0
    return f"{some.size} {some.mean().round(12) + 0.0:.4g} {some[-1]:.4g}" if some.size else "none"


def text_of(text):
    return f"{text.get_text()!r} {text.get_fontsize():g} {to_hex(text.get_color())}"


def line_of(line):
    mark = f"{line.get_marker()} {line.get_markersize():g} {to_hex(line.get_markerfacecolor())}"
    stroke = f"{line.get_linestyle()} {line.get_linewidth():.3g} {to_hex(line.get_color())}"
    data = f"x {short(line.get_xdata())} y {short(line.get_ydata())}"
    return f"line {line.get_label()!r} {stroke} {mark} z {line.get_zorder():g} {data}"


def collection_of(one):
    colors = sorted({to_hex(color, True) for color in (*one.get_edgecolor(), *one.get_facecolor())})
    paths = np.concatenate([[0.0], *(path.vertices.ravel() for path in one.get_paths())])
    values = "" if one.get_array() is None else short(one.get_array())
    widths = np.unique(one.get_linewidth()).round(3).tolist()
    return f"{type(one).__name__} {colors[:8]} {widths} {short(paths)} {values}"


def panel_of(axes):
    """Lines on one panel, and on those inside it."""
    yield f"panel {axes.get_label()!r} {axes.get_aspect()} axis {axes.axison}"
    for axis in (axes.xaxis, axes.yaxis):
        low, high = sorted(axis.get_view_interval())
        ticks = short(axis.get_ticklocs()) if axes.axison else ""
        kept = axis.get_tick_params()
        bare = "".join(f" no {name}" for name in kept if kept[name] is False)
        scale = f"{axis.get_scale()} {low:.4g} {high:.4g}"
        yield f"{axis.get_label_text()!r} {scale} ticks {ticks}{bare}"
    yield from map(text_of, (axes.title, *axes.texts))
    yield from map(line_of, axes.lines)
    yield from map(collection_of, axes.collections)
    yield from (f"patch {to_hex(one.get_facecolor(), True)}" for one in axes.patches)
    for inner in axes.child_axes:
        yield from panel_of(inner)


def look_of(figure):
    width, height = figure.get_size_inches()
    yield f"page {width:.3g} {height:.3g}"
    for axes in filter(Artist.get_visible, figure.axes):
        yield from panel_of(axes)
    yield from map(text_of, figure.texts)
    for legend in figure.legends:
        yield f"legend {legend._ncols} {[text_of(text) for text in legend.get_texts()]}"


@pytest.mark.parametrize("kind", ROWS)
@pytest.mark.parametrize("count", [1, 6, 7])
def test_a_figure_looks_as_before(kind, count, snapshot):
    assert "\n".join(look_of(drawn(kind, count))) == snapshot

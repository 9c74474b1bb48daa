"""How a figure looks, in words: pages, axes, lines, marks and texts."""

import numpy as np
from matplotlib.collections import Collection, QuadMesh
from matplotlib.colors import to_hex
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.spines import Spine
from matplotlib.text import Annotation, Text

# Of very many lines in the same axes the first ones tell the look.
MOST, MOST_PANELS = 18, 6


def number(value):
    return "–" if value is None else f"{float(value) + 0.0:.4g}"


def numbers(values):
    return " ".join(number(value) for value in np.ravel(values))


def along(values):
    """First and last value of a series, how many there are, and their mean."""
    values = np.asarray(values, dtype=float)
    if not values.size:
        return "none"
    known = values[~np.isnan(values)]
    mean = known.mean() if len(known) else np.nan
    return f"{numbers(values[[0, -1]])}, {len(values)} with mean {number(mean)}"


def colors(values):
    found = dict.fromkeys(to_hex(color, keep_alpha=True) for color in np.atleast_2d(values))
    return " ".join(found)


def words(text):
    return f"{text.get_text()!r} {number(text.get_fontsize())} pt {to_hex(text.get_color())}"


def ticks(axis):
    """Say where an axis has its marks, and what stands there if it is no number as usual."""
    marks = axis.get_major_ticks()
    look = {
        f"{number(mark.label1.get_fontsize())} pt, {number(mark.tick1line.get_markersize())} long"
        + ", not written" * (not mark.label1.get_visible())
        + f", grid {number(mark.gridline.get_linewidth())}" * mark.gridline.get_visible()
        for mark in marks
    }
    labels = [text.get_text() for text in axis.get_ticklabels()]
    places = numbers(axis.get_ticklocs())
    return f"{places} as {' '.join(labels)}, {'; '.join(look)}, {len(axis.get_minor_ticks())}"


def anchored(legend):
    """Say by which of its corners a legend hangs, and where, as parts of its axes or page."""
    whole = legend.axes.transAxes if legend.axes else legend.get_figure().transFigure
    place = legend.get_bbox_to_anchor().transformed(whole.inverted())
    return f"by {legend._loc_real} at {numbers(np.round(place.extents, 3))}"


def described(artist):
    """Say in one line what an artist shows; nothing of those that show nothing."""
    look = f"z {number(artist.get_zorder())}"
    if isinstance(artist, Line2D):
        marks = f"{artist.get_marker()} {number(artist.get_markersize())}"
        if artist.get_marker() != "None":
            marks += f" {to_hex(artist.get_markerfacecolor(), keep_alpha=True)}"
        return (
            f"line {artist.get_label()!r} {artist.get_color()} {artist.get_linestyle()} "
            f"{number(artist.get_linewidth())} {artist.get_alpha()} {look}, marks {marks}, "
            f"x {along(artist.get_xdata())}, y {along(artist.get_ydata())}"
        )
    if isinstance(artist, QuadMesh):
        return f"mesh {artist.get_coordinates().shape} of {along(artist.get_array().ravel())}"
    if isinstance(artist, Collection):
        places = np.asarray(artist.get_offsets(), dtype=float)
        if artist.get_paths() and len(places) == 1 and not places.any():
            places = np.concatenate([path.vertices for path in artist.get_paths()])
        return (
            f"{type(artist).__name__} {artist.get_label()!r} {colors(artist.get_facecolor())}; "
            f"{colors(artist.get_edgecolor())} {numbers(artist.get_linewidth())} {look}, "
            f"at x {along(places[:, 0])}, y {along(places[:, 1])}"
        )
    if isinstance(artist, Legend):
        texts = "; ".join(words(text) for text in artist.get_texts())
        title = artist.get_title().get_text()
        return f"legend {title!r} {anchored(artist)} in {artist._ncols} columns: {texts}"
    if isinstance(artist, Text) and artist.get_text():
        where = f"{artist.get_ha()} {artist.get_va()} of {numbers(artist.get_position())}"
        if isinstance(artist, Annotation):
            where += f" in {artist.anncoords} from {numbers(artist.xy)} in {artist.xycoords}"
        return f"text {words(artist)} {where}, wraps: {artist.get_wrap()}"
    if isinstance(artist, Patch) and not isinstance(artist, Spine):
        corners = artist.get_patch_transform().transform(artist.get_path().vertices)
        return (
            f"patch {artist.get_label()!r} {to_hex(artist.get_facecolor(), keep_alpha=True)} "
            f"{to_hex(artist.get_edgecolor())} {number(artist.get_linewidth())} "
            f"{artist.get_hatch()} {look}, x {along(corners[:, 0])}, y {along(corners[:, 1])}"
        )
    return None


def axes_described(axes, most):
    titles = (axes.title, axes._left_title, axes._right_title, axes.patch)
    shown = (described(artist) for artist in axes.get_children() if artist not in titles)
    shows = list(filter(None, shown))
    return {
        "words": [words(text) for text in (axes.title, axes.xaxis.label, axes.yaxis.label)],
        "frame": " ".join(name for name, one in axes.spines.items() if one.get_visible()),
        "place": numbers(np.round(axes.get_position().bounds, 3)),
        "limits": f"x {numbers(axes.get_xlim())}, y {numbers(axes.get_ylim())}",
        "marks": [ticks(axes.xaxis), ticks(axes.yaxis)],
        "scales": f"{axes.get_xscale()} {axes.get_yscale()}, aspect {axes.get_aspect()}",
        "insets": [axes_described(inset, most) for inset in axes.child_axes],
        "shows": [*shows[:most], *(f"and {more} more" for more in [len(shows) - most] if more > 0)],
    }


def figure_described(figure, most=MOST):
    return {
        "page": numbers(figure.get_size_inches()),
        "beside": [described(artist) for artist in (*figure.legends, *figure.texts)],
        "panels": len(figure.axes),
        "axes": [axes_described(axes, most) for axes in figure.axes[:MOST_PANELS]],
    }

"""Every kind of figure with few and with many series: data have room, nothing is cut off."""

import warnings

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from figure_rows import ROWS, drawn
from vibrissa.figures import style
from vibrissa.figures.kinds import KINDS

TO_SCALE = ("scan", "period", "slip", "state", "swing")
# Kinds whose series have colours, by the quantity that tells them apart.
SERIES = {
    "taper": r"\mu_0",
    "locking": r"\eta",
    "law": r"\theta",
    "past_lock": r"\theta",
    "margins": r"\theta",
    "models": r"\mu_0",
    "mounting": r"\theta",
}


def test_every_kind_is_laid_out():
    assert ROWS.keys() == KINDS.keys()


def is_bar(axes):
    return axes.get_label() == "<colorbar>"


def texts_of(axes):
    labels = (axes.title, axes.xaxis.label, axes.yaxis.label)
    return [text for text in (*labels, *axes.texts) if text.get_text()]


# These have the most panels and texts.
LONG = ("regimes", "slopes", "versus")
MANY = [
    pytest.param(kind, 40, marks=pytest.mark.nightly if kind in LONG else pytest.mark.slow)
    for kind in ROWS
]
# Of some kinds few series stand in a legend, in the place of a colourbar.
FEW = [
    (kind, 6) if kind in {*SERIES, *LONG} else pytest.param(kind, 6, marks=pytest.mark.nightly)
    for kind in ROWS
]


@pytest.mark.parametrize(("kind", "count"), [*FEW, *MANY])
def test_the_data_have_room_and_nothing_is_cut_off(kind, count):
    figure = drawn(kind, count)
    FigureCanvasAgg(figure)
    with style.applied(), warnings.catch_warnings():
        warnings.simplefilter("error")
        figure.draw_without_rendering()
    renderer, page = figure.canvas.get_renderer(), figure.bbox.padded(1.0)
    panels = [axes for axes in figure.axes if axes.get_visible() and axes.axison]
    places = [axes.get_position() for axes in panels if not is_bar(axes)]
    area = sum(place.width * place.height for place in places)
    assert area > (0.09 if kind in TO_SCALE else 0.3)
    texts = [text for axes in panels for text in texts_of(axes)] + figure.texts
    boxes = [text.get_window_extent(renderer) for text in texts]
    legends = [legend.get_window_extent(renderer) for legend in figure.legends]
    for box in (*boxes, *legends):
        assert page.containsx(box.x0) and page.containsx(box.x1)
        assert page.containsy(box.y0) and page.containsy(box.y1)
    frames = [axes.get_window_extent(renderer) for axes in panels]
    for legend in legends:
        assert not any(legend.overlaps(box) for box in (*boxes, *frames))
    assert min(text.get_fontsize() for text in texts) >= 5.0


@pytest.mark.slow
@pytest.mark.parametrize("kind", SERIES)
def test_a_colourbar_names_many_series(kind):
    figure = drawn(kind, 20)
    (bar,) = filter(is_bar, figure.axes)
    names = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert not any(f"${SERIES[kind]} = " in name for name in names)
    assert bar.get_ylabel() == f"${SERIES[kind]}$"
    values = [float(text.get_text()) for text in bar.get_yticklabels()]
    assert len(values) == 20 and values == sorted(values)

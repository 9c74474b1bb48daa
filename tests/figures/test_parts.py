"""Parts of a figure: each panel with its texts, in the order in which they are read."""

import json

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg

from vibrissa.figures import style
from vibrissa.figures.parts import parts_of


def laid_out(rows, columns, bar=False, legend=False):
    figure = style.page(3.0, style.PAGE)
    panels = figure.subplots(rows, columns, squeeze=False)
    for panel in panels.flat:
        panel.plot([0, 1], [0, 1], label="a line")
        panel.set(xlabel="x", ylabel="y", title="a title")
    if bar:
        image = panels.flat[-1].pcolormesh(np.eye(3))
        figure.colorbar(image, ax=panels.flat[-1])
    if legend:
        style.legend(figure)
    FigureCanvasAgg(figure)
    figure.draw_without_rendering()
    return figure, panels


def parts(figure):
    return json.loads(parts_of(figure) or "[]")


def test_panels_are_parts_in_the_order_of_reading_and_do_not_overlap():
    figure, panels = laid_out(2, 3)
    found = np.array(parts(figure))
    assert len(found) == 6 and (found >= 0.0).all() and (found <= 1.0).all()
    for (left, top, right, bottom), panel in zip(found, panels.flat, strict=True):
        box = panel.get_position()
        assert left < box.x0 < box.x1 < right and top < 1 - box.y1 < 1 - box.y0 < bottom
    for i, one in enumerate(found):
        for other in found[i + 1 :]:
            apart = np.maximum(one[:2], other[:2]) - np.minimum(one[2:], other[2:])
            assert apart.max() > -0.02


def test_a_legend_is_a_part_below_and_a_bar_of_colours_stays_with_its_panel():
    figure, _ = laid_out(1, 2, bar=True, legend=True)
    found = parts(figure)
    assert len(found) == 3 and found[2][1] > max(found[0][3], found[1][3]) - 0.02
    bar = figure.axes[-1].get_position()
    assert found[1][2] > bar.x1


def test_a_single_panel_and_panels_above_each_other_have_no_parts():
    assert parts_of(laid_out(1, 1)[0]) == parts_of(laid_out(3, 1, legend=True)[0]) == ""

"""Parts of a figure that a narrow screen may show below each other: panels, legends, titles."""

import json
from collections.abc import Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

# A part that is narrower, such as a bar of colours, stays with its neighbour; room around a part.
NARROW, ROOM = 0.2, 0.005
# If all panels are wider, a figure is not cut: its parts would be no larger than the whole.
WIDE = 0.7


def parts_of(figure: Figure) -> str:
    """Return the parts of a figure that has been laid out, as JSON; empty if it is not cut.

    Each part has left, top, right and bottom as fractions of the figure's size, from its upper left
    corner. The parts are in the order in which they are read: by rows, then from left to right.
    """
    pages = [figure, *figure.subfigs]
    legends = [legend for page in pages for legend in page.legends]
    if len(figure.axes) + len(legends) < 2:
        return ""
    panels = _joined(_boxes(figure, figure.axes))
    if all(box.width > WIDE for box in panels):
        return ""
    found = panels + _boxes(figure, legends)
    if len(found) < 2:
        return ""
    rows = _by_rows(found)
    edges = [
        [box.x0 - ROOM, 1.0 - box.y1 - ROOM, box.x1 + ROOM, 1.0 - box.y0 + ROOM] for box in rows
    ]
    return json.dumps(np.clip(edges, 0.0, 1.0).round(4).tolist())


def _boxes(figure: Figure, drawn: Sequence[Artist]) -> list[Bbox]:
    """Return the boxes of what is drawn, texts included, as fractions of the figure's size."""
    width, height = figure.bbox.size
    boxes = [artist.get_tightbbox() for artist in drawn if artist.get_visible()]
    return [
        Bbox.from_extents(box.x0 / width, box.y0 / height, box.x1 / width, box.y1 / height)
        for box in boxes
        if box is not None and box.width > 0.0
    ]


def _joined(boxes: list[Bbox]) -> list[Bbox]:
    """Join boxes that overlap, and narrow ones with their neighbours."""
    for i, one in enumerate(boxes):
        others = boxes[:i] + boxes[i + 1 :]
        over = [other for other in others if one.padded(-1e-3).overlaps(other)]
        if not over and one.width < NARROW and others:
            over = [min(others, key=lambda other: _distance(one, other))]
        if over:
            rest = [other for other in others if other is not over[0]]
            return _joined([*rest, Bbox.union([one, over[0]])])
    return boxes


def _distance(one: Bbox, other: Bbox) -> float:
    """Distance of two boxes: 0 if they overlap."""
    across = max(one.x0, other.x0) - min(one.x1, other.x1)
    up = max(one.y0, other.y0) - min(one.y1, other.y1)
    return float(np.hypot(max(across, 0.0), max(up, 0.0)))


def _by_rows(boxes: list[Bbox]) -> list[Bbox]:
    """Sort boxes by rows, from the top, and within a row from the left."""
    left, rows = sorted(boxes, key=lambda box: -box.y1), []
    while left:
        middle = 0.5 * (left[0].y0 + left[0].y1)
        row = [box for box in left if box.y1 > middle]
        rows += sorted(row, key=lambda box: box.x0)
        left = [box for box in left if box not in row]
    return rows

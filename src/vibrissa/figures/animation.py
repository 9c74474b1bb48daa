"""Animation of scans as APNG: rods of several tapers side by side, through all their cycles."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.lines import Line2D
from PIL import Image

from vibrissa.figures import shapes, style, symbols
from vibrissa.figures.scans import SHAPES, begins
from vibrissa.figures.style import COLORS, END, INK, SHAPE
from vibrissa.files import write_atomically

COLUMNS = ("theta", "mu0", "eta", *SHAPES)
# Number of frames, their duration and that of the last one (ms), and resolution (dots per inch).
FRAMES, DURATION, PAUSE, RESOLUTION = 70, 90, 2500, 90
# Number of colours of a frame: fewer make the file smaller.
PALETTE = 32
# Rounding errors of positions (L).
NEAR = 1e-12


def save(rows: pd.DataFrame, path: str | Path) -> None:
    """Write the scans in `rows` as an animation, all clamps at the same speed.

    Parameters
    ----------
    rows : DataFrame
        Rows of the table `scans` that have a result, with the columns `COLUMNS`.
    path : str or Path
        File that is written.
    """
    with style.applied():
        pictures = list(_frames(rows))
        # The colours of the last frame, which shows everything; dots would not compress well.
        palette = pictures[-1].quantize(PALETTE)
        plain = Image.Dither.NONE
        frames = [each.quantize(palette=palette, dither=plain) for each in pictures]
        durations = [DURATION] * (len(frames) - 1) + [PAUSE]
        with write_atomically(Path(path)) as temporary:
            # A viewer that knows no animations shows the last frame.
            frames[-1].save(
                temporary,
                format="PNG",
                save_all=True,
                append_images=frames,
                default_image=True,
                duration=durations,
                loop=0,
            )


def _frames(rows: pd.DataFrame) -> Iterator[Image.Image]:
    """Draw the rods after equal parts of the path of the clamp."""
    scans = [steps for _, steps in rows.groupby(["mu0", "theta"])]
    etas = [float(steps["eta"].iloc[0]) for steps in scans]
    room = shapes.room_of(rows)
    figure, panels = shapes.panels(etas, room, len(scans), len(scans))
    canvas = FigureCanvasAgg(figure)
    figure.set_dpi(RESOLUTION)
    films = [_Film(panel, steps, room) for panel, steps in zip(panels, scans, strict=True)]
    # What does not move is laid out and drawn once.
    canvas.draw()  # type: ignore[no-untyped-call]
    rest = canvas.copy_from_bbox(figure.bbox)  # type: ignore[no-untyped-call]
    longest = max(float(film.moved[-1]) for film in films)
    for moved in np.linspace(0.0, longest, FRAMES):
        canvas.restore_region(rest)  # type: ignore[no-untyped-call]
        for film in films:
            film.move(float(moved))
            for artist in film.moving:
                film.panel.draw_artist(artist)
        pixels = canvas.buffer_rgba()  # type: ignore[no-untyped-call]
        size = canvas.get_width_height()
        yield Image.frombuffer("RGBA", size, pixels).convert("RGB")


class _Film:
    """A rod that moves in a panel: it, its shape as the period began, and the slips so far."""

    def __init__(self, panel: Axes, steps: pd.DataFrame, room: shapes.Room) -> None:
        self.panel = panel
        self.footpoint, self.tips, self.shape_x, self.shape_y = (
            steps[name].to_numpy() for name in ("footpoint", "x1", "shape_x", "shape_y")
        )
        # How far the clamp has moved at each step (L).
        self.moved = np.abs(np.diff(self.footpoint, prepend=self.footpoint[0])).cumsum()
        # Steps in which a period begins, and those of the slips.
        self.begins = np.flatnonzero(begins(steps))
        self.slips = np.flatnonzero(steps["phase"] == "slip")
        self.eta = float(steps["eta"].iloc[0])
        first = steps.iloc[0]
        names = (("theta", r"\theta"), ("mu0", r"\mu_0"))
        panel.set_title(
            ", ".join(f"${text} = {first[name]:g}$" for name, text in names), loc="left"
        )
        self.begun = Line2D([], [], color=SHAPE, linewidth=1.2)
        self.rod = Line2D([], [], color=COLORS[0], linewidth=1.8)
        self.clamp = Line2D([], [], color=INK, linewidth=3.0)
        self.tip = Line2D([], [], color=COLORS[0], marker="o", markersize=4)
        self.arcs = Line2D([], [], color=END, linewidth=1.0)
        low = room.bottom + 0.03
        self.place = panel.text(room.left + 0.03, low, "")
        # A text of its own to the right of it, as matplotlib takes its time for each new formula.
        self.count = panel.annotate(
            "", (1.0, low), (2.0, 0.0), (self.place, "data"), "offset points"
        )
        # Each frame draws these, in this order.
        lines = [self.begun, self.rod, self.clamp, self.tip, self.arcs]
        self.moving: list[Artist] = [*lines, self.place, self.count]
        for line in lines:
            panel.add_line(line)
        for artist in self.moving:
            artist.set_animated(True)

    def move(self, moved: float) -> None:
        """Draw the state after the last step up to which the clamp has moved this far (L)."""
        now = np.searchsorted(self.moved, moved + NEAR, side="right") - 1
        begun = self.begins[self.begins <= now][-1]
        slips = self.slips[self.slips <= now]
        self.begun.set_data(self.shape_x[begun], self.shape_y[begun])
        self.rod.set_data(self.shape_x[now], self.shape_y[now])
        x, y = float(self.shape_x[now][0]), float(self.shape_y[now][0])
        self.clamp.set_data([x - symbols.HALF_CLAMP, x + symbols.HALF_CLAMP], [y, y])
        self.tip.set_data([self.tips[now]], [self.eta])
        self.arcs.set_data(*symbols.arcs_of_slips(self.tips[slips - 1], self.tips[slips], self.eta))
        self.place.set_text(f"clamp at {self.footpoint[now]:.3f}")
        self.count.set_text(f"$L$, slips: {len(slips)}")

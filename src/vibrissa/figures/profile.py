"""Figure of the profile under the tip, as `vibrissa identify` finds it."""

from pathlib import Path

import pandas as pd

from vibrissa.figures import style


def save_profile(rows: pd.DataFrame, path: Path) -> None:
    """Draw heights over positions with their standard deviations, and write the figure.

    Parameters
    ----------
    rows : DataFrame
        Table of a `vibrissa.sensor.ContactProfile`, whose ``attrs`` have the units.
    """
    unit = rows.attrs["units"]["x"]
    # Samples of one period of sticking are at one place.
    shown = rows.sort_values("x")
    with style.applied():
        figure, panel = style.axes(2.4)
        low, high = (
            shown["height"] + sign * shown["height_deviation"].to_numpy() for sign in (-1.0, 1.0)
        )
        look: style.Look = {"color": style.SHAPE, "linewidth": 0, "label": "noise and tolerances"}
        panel.fill_between(shown["x"], low, high, **look)
        panel.errorbar(
            shown["x"],
            shown["height"],
            xerr=shown["x_noise"],
            yerr=shown["height_noise"],
            fmt=".",
            markersize=2,
            color=style.START,
            elinewidth=0.5,
        )
        dot: style.Look = {"marker": ".", "linestyle": "none", "color": style.START}
        style.mean(panel, "samples, with their noise", **dot)
        panel.set(xlabel=f"contact point / {unit}", ylabel=f"height / {unit}")
        panel.ticklabel_format(axis="both", style="sci", scilimits=(-3, 3))
        style.legend(figure)
        style.save(figure, [path], title="Profile under the tip")

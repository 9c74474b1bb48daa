"""Picture of a measured rod and of the rod of the model that is fitted to it."""

import numpy as np
from matplotlib.figure import Figure

from vibrissa.figures import style
from vibrissa.numerics.arrays import FloatArray


def fit(
    position: FloatArray,
    values: tuple[FloatArray, FloatArray],
    fitted: tuple[FloatArray, FloatArray],
) -> Figure:
    """Draw diameter and bending stiffness along a rod.

    Parameters
    ----------
    position : ndarray, shape (n,)
        Distances from the clamp (mm).
    values : tuple of ndarray, shape (n,) each
        Measured diameters (mm) and stiffnesses (N·mm²).
    fitted : tuple of ndarray, shape (k,) each
        The same of the fitted rod, at k equally spaced places.
    """
    with style.applied():
        figure = style.page(2.6, 2.0 * style.COLUMN)
        names = ("diameter / mm", "cone"), ("bending stiffness / N mm$^2$", "fit")
        for panel, (name, label), measured, model in zip(
            figure.subplots(1, 2), names, values, fitted, strict=True
        ):
            along = np.linspace(0.0, position[-1], len(model))
            panel.plot(along, model, color="black", label=label)
            panel.plot(position, measured, "o", label="measured")
            panel.set_xlabel("distance from the clamp / mm")
            panel.set_ylabel(name)
            panel.legend()
        figure.axes[1].set_yscale("log")
    return figure

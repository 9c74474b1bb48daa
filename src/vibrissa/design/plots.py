"""Drawing of a design. Matplotlib is loaded with this module."""

import numpy as np
from matplotlib.figure import Figure

from vibrissa.design.result import Design


def design(found: Design) -> Figure:
    """Draw the uncertainty over μ0, and all pairs (θ, η) that were solved."""
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    known = found.uncertainty
    for values, label in (
        (known.whole, "whole"),
        (known.by_step, "by the step"),
        (known.by_reading, "by the noise"),
        (known.by_tolerances, "by the tolerances"),
    ):
        left.plot(found.mu0, values, label=label)
    left.set(xlabel="static friction μ0", ylabel="uncertainty of μ0", ylim=(0.0, None))
    left.legend()
    pairs = found.pairs
    if len(found.pair_uncertainty):
        good = np.isfinite(found.pair_uncertainty)
        right.plot(pairs.theta[~good], pairs.eta[~good], ".", color="0.8", label="no rod")
        values = found.pair_uncertainty[good]
        dots = right.scatter(pairs.theta[good], pairs.eta[good], c=values, norm="log", s=18)
        figure.colorbar(dots, ax=right, label="largest uncertainty of μ0")
    right.plot(found.theta, found.eta, "*", color="C3", markersize=12, label="the rod")
    right.legend(loc="lower right")
    right.set(xlabel="taper θ", ylabel="height η / L")
    return figure

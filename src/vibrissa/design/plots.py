"""Drawing of a design. Matplotlib is loaded with this module."""

import numpy as np
from matplotlib.figure import Figure

from vibrissa.design.result import Design


def design(found: Design) -> Figure:
    """Draw the uncertainty over μ0, and all pairs (θ, η) that were solved."""
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    best = found.best
    for values, label in (
        (best.whole, "whole"),
        (best.by_step, "by the step"),
        (best.by_reading, "by the noise"),
        (best.by_tolerances, "by the tolerances"),
    ):
        left.plot(found.mu0, values, label=label)
    left.set(xlabel="static friction μ0", ylabel="uncertainty of μ0", ylim=(0.0, None))
    left.legend()
    right.plot(found.pairs.theta, found.pairs.eta, ".", color="0.8", label="no rod")
    if found.rods:
        # The best of a pair is drawn last, over the others.
        theta, eta, largest = np.array([(r.theta, r.eta, r.largest) for r in found.rods[::-1]]).T
        dots = right.scatter(theta, eta, c=largest, norm="log", s=18, zorder=2)
        figure.colorbar(dots, ax=right, label="largest uncertainty of μ0")
    right.plot(best.theta, best.eta, "*", color="C3", markersize=12, label="the rod")
    right.legend(loc="lower right")
    right.set(xlabel="taper θ", ylabel="height η / L")
    return figure

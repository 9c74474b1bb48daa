"""Curves, their pieces and states that are made up: what is found on them is known."""

from numpy.polynomial import Polynomial

from vibrissa.numerics.spectral import chebyshev_nodes
from vibrissa.outcomes import Contact, Parameter, RodSection, Status
from vibrissa.sticking.assembly import assembled_curves
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.piece import Piece, StickingState

# Columns of the parameter t.
COLUMNS = {
    "x0": Polynomial([0.0, 1.0]),
    "reaction_fx": Polynomial([0.0, -2.0, 0.5]),
    "reaction_fy": Polynomial([-2.0, 0.5, -0.25, 0.125]),
    "reaction_m": Polynomial([1.0, -3.0, 2.0, -1.0]),
    "phi1": Polynomial([0.5, -1.0]),
    "s_c": Polynomial([1.0]),
    "stability": Polynomial([0.9, 0.2]),
    "stability_aside": Polynomial([0.5, -0.75]),
}
# A contact that needs −tan α = t·(2 − t), which is largest at t = 1.
NEEDS = COLUMNS | {
    "reaction_fx": Polynomial([0.0, -2.0, 1.0]),
    "reaction_fy": Polynomial([-1.0]),
    "phi1": Polynomial([0.5]),
}


def made(
    start,
    stop,
    columns=COLUMNS,
    count=9,
    parameter=Parameter.X0,
    contact=Contact.POINT,
):
    """A piece whose columns are known everywhere."""
    t = start + (stop - start) * chebyshev_nodes(count)
    states = {name: columns[name](t) for name in StickingState.names()}
    return Piece(
        contact=contact,
        parameter=parameter,
        start=start,
        stop=stop,
        states=StickingState(**states),
    )


def curve_of(*pieces, events=(), **more):
    """A curve of pieces that begins at x1 = 0.6."""
    given = {"theta": 2.0, "eta": 0.8, "method": "made", "x1_init": 0.6, "residual": 1e-13}
    given |= {"status": Status.SOLVED, "section": RodSection.PLANAR, "end_message": "not followed"}
    followed = StickingCurve(**given | more, pieces=pieces)
    (curve,) = assembled_curves([followed], [events or [()] * len(pieces)])
    return curve


def rising(stop, start=0.0, **columns):
    return made(start, stop, NEEDS | columns)

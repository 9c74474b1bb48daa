"""Tables of a small study, by its code but without its workflow."""

from decimal import Decimal
from functools import cache

import pyarrow as pa

from made_tables import grid, points
from vibrissa import Mounting, solve_curve, solve_state, stick_slip
from vibrissa.computing.scans import scan_tables
from vibrissa.computing.states import states_table
from vibrissa.sticking.curve import failed_curve

MU0 = (0.2, 0.3, 0.45, 0.9)
FAILED = failed_curve(theta=9.0, eta=0.85, method="collocation", message="no luck")


@cache
def curves():
    """Curves of a cylinder, of a rod that lies down, and of one that was not found."""
    return {1.0: solve_curve(1.0, 0.85), 3.0: solve_curve(3.0, 0.85, contact="line"), 9.0: FAILED}


@cache
def stiction():
    """Two grids, of which one lies within the other."""
    parts = [
        points(name, grid(thetas, MU0, dx0=(0.01,)), "small", [curves()[theta] for theta in thetas])
        for name, thetas in {"main": (1.0, 3.0, 9.0), "more": (3.0,)}.items()
    ]
    return pa.concat_tables(parts)


@cache
def scanned():
    """Three scans: one that slips, one that swings aside and is dragged, one without states."""
    parts = []
    for theta, mu0, step in ((1.0, 0.3, "0.004"), (3.0, 0.9, "0.1"), (9.0, 0.3, "0.01")):
        point = {name: values[0] for name, values in grid((theta,), MU0, dx0=(0.01,)).items()}
        point |= {"surface": "plane", "law": "free"}
        curve = curves()[theta]
        scan = stick_slip(curve, mu0, Decimal(step), 2)
        about = {"study": "small", "method": curve.method, "shapes": True}
        parts.append(scan_tables("runs", point, scan, **about))
    return parts


@cache
def scans():
    return pa.concat_tables([part.steps for part in scanned()])


@cache
def periods():
    return pa.concat_tables([part.periods for part in scanned()])


@cache
def states():
    mounted = Mounting(clamp_angle=0.05, curvature=(0.1, -0.2))
    return states_table(
        {
            "inside": solve_state(1, 0.55, 0.15),
            "lies": solve_state(3, 0.75, 0.3, contact="line"),
            "mounted": solve_state(2, 0.85, 0.3, mounting=mounted),
            "lost": solve_state(2, 0.85, 0.3, mounting=Mounting(curvature=-2.0)),
        },
        "small",
    )


def tables():
    return {"stiction": stiction(), "scans": scans(), "periods": periods(), "states": states()}


def columns(table):
    """All columns of a table, of which long lists are told by their first, middle and last item."""
    found = {}
    for name in table.schema.names:
        values = table.column(name).to_pylist()
        if "list<" in str(table.schema.field(name).type):
            values = [[row[0], row[len(row) // 2], row[-1]] if row else [] for row in values]
        elif any(isinstance(value, float | int) for value in values):
            values = [float("nan") if value is None else value for value in values]
        found[name] = values
    return found

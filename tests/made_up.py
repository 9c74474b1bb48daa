"""Made-up tables of grid points."""

from decimal import Decimal

import pyarrow as pa

from vibrissa.study.grid import MOUNTING_AXES, Grid, study_points
from vibrissa.tables.schemas import STICTION

COUNTS = {"theta": 6, "mu0": 4, "eta": 5, "dx0": 2}


def grid(**counts):
    """A grid with so many values on each axis."""
    sizes = COUNTS | counts
    return Grid(**{name: tuple(Decimal(i + 1) / 10 for i in range(n)) for name, n in sizes.items()})


# The second lies within the first, and reaches beyond it.
GRIDS = {"main": grid(), "more": grid(theta=2, mu0=5)}


def point_table(points):
    """Made-up results at grid points: (theta, mu0, eta, dx0) with the names of the grids."""
    columns = {}
    for field in STICTION:
        if field.name in ("theta", "mu0", "eta", "dx0"):
            position = ("theta", "mu0", "eta", "dx0").index(field.name)
            values = [float(point[position]) for point, _ in points]
        elif field.name in MOUNTING_AXES:
            values = [0.0] * len(points)
        elif field.name == "grids":
            values = [names for _, names in points]
        elif field.type == pa.string():
            values = ["slip" if field.name == "status" else ""] * len(points)
        elif field.nullable:
            values = [None] * len(points)
        columns[field.name] = pa.array(values, field.type)
    return pa.table(columns, schema=STICTION)


def all_points(grids=GRIDS):
    return [
        ((key.theta, mu0, key.eta, dx0), names)
        for key, points in study_points(grids)
        for mu0, dx0, names in zip(points.mu0, points.dx0, points.grids, strict=True)
    ]


COMPLETE = point_table(all_points())

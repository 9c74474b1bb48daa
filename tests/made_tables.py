"""Tables by the code of the workflow's jobs, but without the workflow."""

from collections.abc import Mapping

import numpy as np
import pyarrow as pa

from vibrissa import stick_slip
from vibrissa.outcomes import Contact, RodSection, Solver
from vibrissa.study.axes import MOUNTING_AXES
from vibrissa.study.chunks import number_of_points, points_of
from vibrissa.tables.points import points_table
from vibrissa.tables.rods import rods_of, solve
from vibrissa.tables.scans import scan_table

SOLVER = {"method": Solver.COLLOCATION, "contact": Contact.POINT, "section": RodSection.ROUND}
IDEAL = dict.fromkeys(MOUNTING_AXES, (0.0,))


def grid(theta=(2.0,), mu0=(0.2, 0.4), eta=(0.85,), dx0=(0.001,), **mounting):
    return {"theta": theta, "mu0": mu0, "eta": eta, "dx0": dx0, **IDEAL, **mounting}


def points(name, axes: Mapping, study="paper", curves=None, **solver):
    """Table of a grid, from its curves or solved."""
    if curves is None:
        curves = solve(rods_of(axes, by_step=False), **SOLVER | solver)
    return points_table(name, axes, np.arange(number_of_points(axes)), curves, study)


def scans(name, section, study="paper"):
    """Table of a set of scans."""
    points = points_of(section.axes)
    return pa.concat_tables(
        [
            scan_table(
                name,
                point,
                stick_slip(curve, point["mu0"], point["dx0"], section.cycles),
                study=study,
                method=Solver.COLLOCATION,
            )
            for point, curve in zip(points, solve(points, **SOLVER), strict=True)
        ]
    )

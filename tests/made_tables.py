"""Tables by the code of the workflow's jobs, but without the workflow."""

from collections.abc import Mapping

import numpy as np
import pyarrow as pa

from vibrissa.computing.points import points_table
from vibrissa.computing.rods import SolverSettings, rods_of, solve
from vibrissa.computing.scans import ScanTables, computed_scans
from vibrissa.outcomes import Contact, RodSection, Solver
from vibrissa.study.axes import MOUNTING_AXES
from vibrissa.study.chunks import number_of_points

SOLVER = SolverSettings(Solver.COLLOCATION, Contact.POINT, RodSection.ROUND)
IDEAL = dict.fromkeys(MOUNTING_AXES, (0.0,))


def grid(theta=(2.0,), mu0=(0.2, 0.4), eta=(0.85,), dx0=(0.001,), **mounting):
    return {"theta": theta, "mu0": mu0, "eta": eta, "dx0": dx0, **IDEAL, **mounting}


def points(name, axes: Mapping, study="paper", curves=None, **solver):
    """Table of a grid, from its curves or solved."""
    if curves is None:
        curves = solve(rods_of(axes, by_step=False), SOLVER._replace(**solver))
    return points_table(name, axes, np.arange(number_of_points(axes)), curves, study)


def scans(name, section, study="paper"):
    """Tables of a set of scans on planes: of their steps with shapes, and of their periods."""
    planes = [{"surface": "plane", "mu0": mu0} for mu0 in section.mu0]
    part = name, section.rods, planes, section.laws, section.to, section.cycles
    found = list(computed_scans(*part, shapes=True, study=study, solver=SOLVER))
    steps, periods = zip(*found, strict=True)
    return ScanTables(pa.concat_tables(steps), pa.concat_tables(periods))

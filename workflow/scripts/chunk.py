"""Solve the rods of one chunk and read its grid points off their equilibrium paths."""

from vibrissa.outcomes import Contact, RodSection, Solver
from vibrissa.pipeline import jobs
from vibrissa.tables import schemas, store
from vibrissa.tables.points import solved_points

with jobs.logged(snakemake.log[0]):
    params = snakemake.params
    parts = solved_points(
        params.grid,
        params.axes,
        params.study,
        method=Solver(params.solver["method"]),
        contact=Contact(params.solver["contact"]),
        section=RodSection(params.solver["section"]),
    )
    store.write_parts(parts, schemas.STICTION, snakemake.output[0], params.part)

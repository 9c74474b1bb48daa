"""Solve the rods of one chunk and read its grid points off their equilibrium paths."""

from vibrissa.computing.points import solved_points, solved_rows
from vibrissa.computing.rods import SolverSettings
from vibrissa.pipeline import jobs
from vibrissa.tables import schemas, store

with jobs.logged(snakemake.log[0]):
    params = snakemake.params
    solved = solved_rows if "file" in params.points else solved_points
    solver = SolverSettings(**params.solver)
    batches = solved(**params.points, study=params.study, solver=solver)
    store.write_batches(batches, schemas.STICTION, snakemake.output[0], params.study_part)

"""Solve the rods of one chunk and read its grid points off their equilibrium paths."""

from vibrissa.computing.points import solved_points, solved_points_of_file
from vibrissa.computing.rods import SolverSettings
from vibrissa.pipeline import jobs
from vibrissa.tables import schemas, store

with jobs.logged(snakemake.log[0]):
    params = snakemake.params
    solved = solved_points_of_file if "file" in params.chunk else solved_points
    solver = SolverSettings(**params.solver)
    batches = solved(**params.chunk, study=params.study, solver=solver)
    store.write_batches(batches, schemas.STICTION, snakemake.output[0], params.study_part)

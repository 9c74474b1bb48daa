"""Compute the scans of one chunk: a table of their steps, and one of their periods."""

from vibrissa.computing.rods import SolverSettings
from vibrissa.computing.scans import computed_scans
from vibrissa.pipeline import jobs
from vibrissa.tables import schemas, store

# The periods of a chunk are few, so that they are kept until all steps are written.
periods = []


def steps(params):
    """Yield the steps of each scan, and keep its periods."""
    solver = SolverSettings(**params.solver)
    for found in computed_scans(**params.chunk, study=params.study, solver=solver):
        periods.append(found.periods)
        yield found.steps


with jobs.logged(snakemake.log[0]):
    params, output = snakemake.params, snakemake.output
    store.write_batches(steps(params), schemas.SCANS, output.steps, params.study_part)
    store.write_batches(periods, schemas.PERIODS, output.periods, params.study_part)

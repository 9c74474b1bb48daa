"""Compute the scans of one chunk: a table of their steps, and one of their periods."""

from vibrissa.computing.rods import SolverSettings
from vibrissa.computing.scans import computed_scans
from vibrissa.pipeline import jobs
from vibrissa.tables import schemas, store

with jobs.logged(snakemake.log[0]):
    # `params.chunk` are those of `vibrissa.study.scans.ScanChunk`.
    params, output = snakemake.params, snakemake.output
    solver = SolverSettings(**params.solver)
    with (
        store.writing(schemas.SCANS, output.steps, params.study_part) as steps,
        store.writing(schemas.PERIODS, output.periods, params.study_part) as periods,
    ):
        for scan in computed_scans(**params.chunk, study=params.study, solver=solver):
            steps.add(scan.steps)
            periods.add(scan.periods)

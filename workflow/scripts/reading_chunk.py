"""Simulate the recordings of one chunk, and read their friction."""

from vibrissa.pipeline import jobs
from vibrissa.readings.rows import read_chunk
from vibrissa.tables import schemas, store

with jobs.logged(snakemake.log[0]):
    params = snakemake.params
    batches = read_chunk(**params.chunk, study=params.study, **params.solver)
    store.write_batches(batches, schemas.FRICTION, snakemake.output[0], params.study_part)

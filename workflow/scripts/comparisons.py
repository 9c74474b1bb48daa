"""Solve points in both kinds of contact."""

from vibrissa.computing.comparisons import comparison_table
from vibrissa.pipeline import jobs
from vibrissa.sticking.comparison import compare
from vibrissa.tables import schemas, store

with jobs.logged(snakemake.log[0]):
    params = snakemake.params
    batches = (
        comparison_table(name, compare(**axes), params.study)
        for name, axes in params.comparisons.items()
    )
    store.write_batches(batches, schemas.COMPARISONS, snakemake.output[0], params.study_part)

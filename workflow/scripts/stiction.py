"""Join the chunks of all grids into one table; refuse chunks of another study file."""

from vibrissa.pipeline import jobs
from vibrissa.tables import query, schemas, store

with jobs.logged(snakemake.log[0]):
    params = snakemake.params
    batches = (
        batch
        for path, chunk_part in zip(snakemake.input, params.chunk_parts, strict=True)
        for batch in query.batches(
            query.opened(path, schemas.STICTION, chunk_part), schemas.STICTION.names
        )
    )
    store.write_batches(batches, schemas.STICTION, snakemake.output[0], params.study_part)

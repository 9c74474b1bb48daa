"""Join the chunks of a table; refuse all damaged chunks and all of other study files."""

from vibrissa.errors import DamagedTableError
from vibrissa.pipeline import jobs
from vibrissa.tables import schemas, store


def rows(params, schema):
    """Yield the rows of all chunks; read all before the damaged ones are refused."""
    damaged = []
    for path, chunk_part in zip(snakemake.input.chunks, params.chunk_parts, strict=True):
        try:
            yield from store.current_batches(path, schema, chunk_part)
        except DamagedTableError as error:
            damaged.append(error)
    if damaged:
        raise ExceptionGroup("damaged chunks", damaged)


with jobs.logged(snakemake.log[0]):
    params = snakemake.params
    schema = schemas.TABLES[params.table]
    store.write_batches(rows(params, schema), schema, snakemake.output[0], params.study_part)

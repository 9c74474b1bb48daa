"""Collect the scans."""

from vibrissa.pipeline import jobs
from vibrissa.tables import schemas, store
from vibrissa.tables.collect import collect

with jobs.logged(snakemake.log[0]):
    found = collect(snakemake.input.scans, schemas.SCANS)
    store.write_parts(
        found.parts, found.schema, snakemake.output[0], snakemake.params.study_file, found.rows
    )

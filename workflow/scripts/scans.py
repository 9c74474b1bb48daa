"""Collect the scans."""

from vibrissa import collecting, jobs, tables

with jobs.logged(snakemake.log[0]):
    found = collecting.collect(snakemake.input.scans, tables.SCANS)
    tables.write_parts(
        found.parts, found.schema, snakemake.output[0], snakemake.params.study_file, found.rows
    )

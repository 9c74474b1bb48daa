"""Collect the scans."""

from vibrissa import jobs, tables

with jobs.logged(snakemake.log[0]):
    table = tables.collect(snakemake.input.scans, tables.SCANS)
    tables.write(table, snakemake.output[0], snakemake.params.study_file)

"""Solve points in both kinds of contact."""

from vibrissa.pipeline import jobs
from vibrissa.sticking.comparison import compare
from vibrissa.tables import records, schemas, store

with jobs.logged(snakemake.log[0]):
    parts = []
    for name, axes in snakemake.params.comparisons.items():
        found = compare(**axes)
        parts.append(records.comparison_table(name, found, snakemake.params.study))
    table = store.joined(parts, schemas.COMPARISONS)
    store.write(table, snakemake.output[0], snakemake.params.study_part)

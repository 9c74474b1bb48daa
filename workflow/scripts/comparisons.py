"""Solve points in both contact models."""

from vibrissa.pipeline import jobs
from vibrissa.sticking.comparison import compare
from vibrissa.tables import records, schemas, store

with jobs.logged(snakemake.log[0]):
    parts = []
    for name, axes in snakemake.params.comparisons.items():
        points = {axis: [float(value) for value in values] for axis, values in axes.items()}
        parts.append(records.comparison_table(name, compare(**points), snakemake.params.study))
    table = store.joined(parts, schemas.COMPARISONS)
    store.write(table, snakemake.output[0], snakemake.params.study_file)

"""Solve points in both contact models."""

from vibrissa import jobs, records, tables
from vibrissa.comparison import compare

with jobs.logged(snakemake.log[0]):
    parts = []
    for name, axes in snakemake.params.comparisons.items():
        points = {axis: [float(value) for value in values] for axis, values in axes.items()}
        parts.append(records.comparison_table(name, compare(**points)))
    table = tables.joined(parts, tables.COMPARISONS)
    tables.write(table, snakemake.output[0], snakemake.params.study_file)

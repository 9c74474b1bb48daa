"""Solve points in both kinds of contact."""

from vibrissa.pipeline import jobs
from vibrissa.sticking.comparison import compare
from vibrissa.study.model import ComparisonSection
from vibrissa.tables import records, schemas, store

with jobs.logged(snakemake.log[0]):
    parts = []
    for name, written in snakemake.params.comparisons.items():
        found = compare(**ComparisonSection.model_validate(written).axes)
        parts.append(records.comparison_table(name, found, snakemake.params.study))
    table = store.joined(parts, schemas.COMPARISONS)
    store.write(table, snakemake.output[0], snakemake.params.study_part)

"""Draw one figure from its table."""

from vibrissa import figures, jobs, tables

with jobs.logged(snakemake.log[0]):
    selection = dict(snakemake.params.figure)
    kind, _ = selection.pop("kind"), selection.pop("caption", "")
    schema = getattr(tables, snakemake.params.table.upper())
    table = tables.Stored(snakemake.input.table, schema)
    figures.save(figures.draw(kind, table, selection), snakemake.output)

"""Draw one figure from its table."""

from vibrissa.figures import style
from vibrissa.figures.draw import draw
from vibrissa.pipeline import jobs
from vibrissa.tables import query, schemas

with jobs.logged(snakemake.log[0]):
    table = query.opened(snakemake.input.table, schemas.TABLES[snakemake.params.table])
    figure = draw(snakemake.params.kind, table, snakemake.params.selection)
    style.save(figure, snakemake.output)

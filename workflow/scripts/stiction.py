"""Put the chunks of all grids into one table, and check that each is complete."""

import yaml

from vibrissa.pipeline import jobs
from vibrissa.study.chunks import number_of_points
from vibrissa.tables import schemas, store
from vibrissa.tables.points import chunk_rows

with jobs.logged(snakemake.log[0]):
    chunks = snakemake.params.chunks
    solver = yaml.safe_dump(snakemake.params.solver)
    parts = (
        part
        for path, (grid, axes) in zip(snakemake.input, chunks, strict=True)
        for part in chunk_rows(path, grid, axes, solver)
    )
    store.write_parts(
        parts,
        schemas.STICTION,
        snakemake.output[0],
        study_part=snakemake.params.study_part,
        rows=sum(number_of_points(axes) for _, axes in chunks),
    )

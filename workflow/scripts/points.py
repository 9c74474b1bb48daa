"""Read the grid points of one block off its sticking curves."""

from vibrissa import grid, jobs, records, tables
from vibrissa.stiction import read_curve

with jobs.logged(snakemake.log[0]):
    grids = {name: grid.from_spelled(axes) for name, axes in snakemake.params.readings.items()}
    curves = records.curves_from_table(tables.read(snakemake.input.curves[0], tables.CURVES))
    readings = (
        (pairs, curves[key], read_curve(curves[key], pairs.mu0, pairs.dx0))
        for key, pairs in grid.readings(curves, grids)
    )
    tables.write_parts(records.stiction_tables(readings), tables.STICTION, snakemake.output[0])

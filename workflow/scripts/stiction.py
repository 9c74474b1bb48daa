"""Collect the grid points of all blocks and check that each is there once."""

from vibrissa import grid, jobs, tables

with jobs.logged(snakemake.log[0]):
    grids = {name: grid.from_spelled(axes) for name, axes in snakemake.params.grids.items()}
    table = tables.collect(snakemake.input.points, tables.STICTION)
    tables.check_points(table, grid.study_points(grids))
    order = [(name, "ascending") for name in ("eta", "theta", "mu0", "dx0")]
    tables.write(table.sort_by(order), snakemake.output[0], snakemake.params.study_file)
    print(tables.status_counts(table))

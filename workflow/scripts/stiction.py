"""Collect the grid points of all blocks, in one order, and check that each is there once."""

from vibrissa import collecting, grid, jobs, tables

with jobs.logged(snakemake.log[0]):
    grids = {name: grid.from_spelled(axes) for name, axes in snakemake.params.grids.items()}
    found = collecting.collect(snakemake.input.points, tables.STICTION, collecting.POINT_ORDER)
    tables.write_parts(
        collecting.checked_points(found.parts, grids),
        found.schema,
        snakemake.output[0],
        snakemake.params.study_file,
        found.rows,
    )
    written = tables.Stored(snakemake.output[0], tables.STICTION, checked=True)
    counts = tables.status_counts(written.parts(["status"]))
    print(", ".join(f"{count} {status}" for status, count in sorted(counts.items())))

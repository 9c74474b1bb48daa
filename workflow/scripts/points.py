"""Read the grid points of one block off its sticking curves."""

from vibrissa.pipeline import jobs
from vibrissa.sticking.stiction import read_curve
from vibrissa.study.codec import decode_grid
from vibrissa.study.grid import points_on_curves
from vibrissa.tables import records, schemas, store

with jobs.logged(snakemake.log[0]):
    grids = {name: decode_grid(axes) for name, axes in snakemake.params.grids.items()}
    curves = records.curves_from_table(store.read(snakemake.input.curves[0], schemas.CURVES))
    results = (
        (points, curves[key], read_curve(curves[key], points.mu0, points.dx0))
        for key, points in points_on_curves(curves, grids)
    )
    tables = records.stiction_tables(results, snakemake.params.study)
    store.write_parts(tables, schemas.STICTION, snakemake.output[0])

"""Read the grid points of one block off its sticking curves, and those that are added to them."""

from vibrissa.pipeline import jobs
from vibrissa.sticking.stiction import read_curve
from vibrissa.study.codec import decode_grid, decode_refinement, encode_key
from vibrissa.study.grid import points_on_curves
from vibrissa.tables import records, schemas, store
from vibrissa.tables.refining import refined_lines, with_added


def read_points(curves, grids, refinements):
    """Points on each curve, the curve, and what was read off it; the log says what was added."""
    for key, points in points_on_curves(curves, grids):
        curve = curves[key]
        lines = list(refined_lines(curve, points, refinements))
        for line in lines:
            print(*encode_key(key), line)
        points = with_added(points, lines)
        yield points, curve, read_curve(curve, points.mu0, points.dx0)


with jobs.logged(snakemake.log[0]):
    grids = {name: decode_grid(axes) for name, axes in snakemake.params.grids.items()}
    refinements = {
        name: decode_refinement(texts) for name, texts in snakemake.params.refinements.items()
    }
    curves = records.curves_from_table(store.read(snakemake.input.curves[0], schemas.CURVES))
    results = read_points(curves, grids, refinements)
    tables = records.stiction_tables(results, snakemake.params.study)
    store.write_parts(tables, schemas.STICTION, snakemake.output[0])

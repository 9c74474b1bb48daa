"""Read the grid points of one block off its sticking curves, and those that refine adds to them."""

from functools import cache

from vibrissa.outcomes import Contact, RodSection
from vibrissa.pipeline import jobs
from vibrissa.study.codec import decode_gaps, decode_grid, decode_refinement, encode_key
from vibrissa.tables import records, schemas, store
from vibrissa.tables.added import refined_metadata
from vibrissa.tables.mounted import mounting_of
from vibrissa.tables.points import points_tables
from vibrissa.tables.refining import refined_points

CONTACT, SECTION = Contact(snakemake.params.contact), RodSection(snakemake.params.section)


def read_curves(paths):
    """Curves of some blocks by their keys."""
    tables = (store.read(path, schemas.CURVES) for path in paths)
    return {
        key: curve for table in tables for key, curve in records.curves_from_table(table).items()
    }


def solve(key):
    """Solve a curve by itself: it is the same whatever else is added."""
    # A job that adds no curve does not depend on the solver.
    from vibrissa.sticking.solving.collocation import solve_curves

    (curve,) = solve_curves(
        [float(key.theta)], [float(key.eta)], CONTACT, [mounting_of(key.mounting)], SECTION
    )
    print(*encode_key(key), curve.status, f"residual {curve.residual:.1e}", curve.message)
    return curve


with jobs.logged(snakemake.log[0]):
    grids = {name: decode_grid(axes) for name, axes in snakemake.params.grids.items()}
    refining = snakemake.params.refining
    refinements = {name: decode_refinement(one) for name, one in refining["refinements"].items()}
    gaps = {name: decode_gaps(texts) for name, texts in refining["gaps"].items()}
    own, neighbours = map(read_curves, (snakemake.input.curves, snakemake.input.neighbours))
    known = own | neighbours
    curve_of = cache(lambda key: known[key] if key in known else solve(key))
    found = refined_points(own, grids, refinements, gaps, curve_of)
    for curve, line in found.lines:
        print(f"{curve} {line}".strip())
    schema = schemas.STICTION
    if refinements:
        points = ((key, on_curve) for key, on_curve, _ in found.points)
        metadata = refined_metadata(refining, points, found.left_over)
        schema = schema.with_metadata(schema.metadata | metadata)
    tables = points_tables((each[1:] for each in found.points), snakemake.params.study)
    store.write_parts(tables, schema, snakemake.output[0])

"""Read the grid points of one block off its sticking curves, and those that refine adds to them."""

from functools import cache

from vibrissa.outcomes import Contact, RodSection
from vibrissa.pipeline import jobs
from vibrissa.study.codec import decode_gaps, decode_grid, decode_refinement, encode_key
from vibrissa.study.grid import points_of, points_on_curves
from vibrissa.tables import records, schemas, store
from vibrissa.tables.added import refined_metadata
from vibrissa.tables.mounted import mounting_of
from vibrissa.tables.points import points_tables
from vibrissa.tables.refining import all_added, curve_lines, refined_lines, with_added

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
    from vibrissa.sticking.collocation import solve_curves

    (curve,) = solve_curves(
        [float(key.theta)], [float(key.eta)], CONTACT, [mounting_of(key.mounting)], SECTION
    )
    return curve


def refined(key, curve, points, refinements, noted):
    """Points on a curve with those that are added along mu0; the log says which."""
    lines = list(refined_lines(curve, points, refinements))
    for line in lines:
        print(*encode_key(key), line)
    noted += lines
    return with_added(points, lines)


def points_and_curves(own, neighbours, grids, refinements, gaps, noted):
    """Key of each curve, the points on it, and the curve; `noted` gets the refined lines."""
    for key, points in points_on_curves(own, grids):
        yield key, refined(key, own[key], points, refinements, noted), own[key]
    known = own | neighbours
    curve_of = cache(lambda key: known[key] if key in known else solve(key))
    added = {}
    for name in sorted(gaps):
        lines = curve_lines(name, grids[name], gaps[name], refinements[name], curve_of)
        for line, keys in lines:
            print(line)
            noted.append(line)
            for key in keys:
                added.setdefault(key, {})[name] = grids[name]
    for key, of_grids in added.items():
        points = refined(key, curve_of(key), points_of(of_grids), refinements, noted)
        yield key, all_added(points), curve_of(key)


with jobs.logged(snakemake.log[0]):
    grids = {name: decode_grid(axes) for name, axes in snakemake.params.grids.items()}
    refining = snakemake.params.refining
    refinements = {name: decode_refinement(one) for name, one in refining["refinements"].items()}
    gaps = {name: decode_gaps(texts) for name, texts in refining["gaps"].items()}
    own, neighbours = map(read_curves, (snakemake.input.curves, snakemake.input.neighbours))
    noted = []
    found = list(points_and_curves(own, neighbours, grids, refinements, gaps, noted))
    schema = schemas.STICTION
    if refinements:
        left = [(line.grid, line.axis, line.left_over) for line in noted if line.left_over]
        more = refined_metadata(refining, ((key, points) for key, points, _ in found), left)
        schema = schema.with_metadata(schema.metadata | more)
    tables = points_tables(((points, curve) for _, points, curve in found), snakemake.params.study)
    store.write_parts(tables, schema, snakemake.output[0])

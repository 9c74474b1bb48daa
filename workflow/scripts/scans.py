"""Move the clamp step by step through all scans."""

from vibrissa.outcomes import Contact, RodSection, Solver
from vibrissa.pipeline import jobs
from vibrissa.sticking.cycles import stick_slip
from vibrissa.study.chunks import points_of
from vibrissa.tables import records, schemas, store
from vibrissa.tables.rods import solve


def tables(params):
    """Yield the table of each scan."""
    method, contact = Solver(params.solver["method"]), Contact(params.solver["contact"])
    section = RodSection(params.solver["section"])
    for name, (axes, cycles) in params.scans.items():
        points = points_of(axes)
        curves = solve(points, method=method, contact=contact, section=section)
        for point, curve in zip(points, curves, strict=True):
            found = stick_slip(curve, point["mu0"], point["dx0"], cycles, contact=contact)
            print(name, *point.values(), found.status, found.message)
            yield records.scan_table(name, point, found, study=params.study, method=method)


with jobs.logged(snakemake.log[0]):
    params = snakemake.params
    store.write_parts(tables(params), schemas.SCANS, snakemake.output[0], params.study_part)

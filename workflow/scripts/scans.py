"""Move the clamp step by step through all scans."""

from vibrissa.outcomes import Contact, RodSection, Solver
from vibrissa.pipeline import jobs
from vibrissa.sticking.cycles import stick_slip
from vibrissa.study.model import ScanSection
from vibrissa.tables import records, schemas, store
from vibrissa.tables.rods import solve


def tables(params):
    """Return the table of each scan."""
    method, contact = Solver(params.solver["method"]), Contact(params.solver["contact"])
    for name, written in params.scans.items():
        scan = ScanSection.model_validate(written)
        points = list(scan.points())
        section = RodSection(params.solver["section"])
        curves = solve(points, method=method, contact=contact, section=section)
        for point, curve in zip(points, curves, strict=True):
            found = stick_slip(curve, point["mu0"], point["dx0"], scan.cycles, contact=contact)
            print(name, *point.values(), found.status, found.message)
            yield records.scan_table(name, point, found, study=params.study, method=method)


with jobs.logged(snakemake.log[0]):
    store.write_parts(
        tables(snakemake.params),
        schemas.SCANS,
        snakemake.output[0],
        study_part=snakemake.params.study_part,
    )

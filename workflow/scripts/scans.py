"""Move the clamp step by step through all scans."""

from vibrissa.pipeline import jobs
from vibrissa.scanning.cycles import stick_slip
from vibrissa.study.chunks import points_of
from vibrissa.tables import schemas, store
from vibrissa.tables.rods import solve
from vibrissa.tables.scans import scan_table


def tables(params):
    """Yield the table of each scan."""
    method = params.solver["method"]
    for name, (axes, cycles) in params.scans.items():
        points = points_of(axes)
        curves = solve(points, **params.solver)
        for point, curve in zip(points, curves, strict=True):
            found = stick_slip(curve, point["mu0"], point["dx0"], cycles)
            print(name, *point.values(), found.status, found.message)
            yield scan_table(
                name,
                point,
                found,
                study=params.study,
                method=method,
                frequencies=params.frequencies,
            )


with jobs.logged(snakemake.log[0]):
    params = snakemake.params
    store.write_batches(tables(params), schemas.SCANS, snakemake.output[0], params.study_part)

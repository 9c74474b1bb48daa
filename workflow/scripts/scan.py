"""Move the clamp through one set of scans."""

from vibrissa import grid, jobs, records, tables
from vibrissa.cycles import stick_slip

with jobs.logged(snakemake.log[0]):
    points = list(grid.from_spelled(snakemake.params.grid).points())
    curves = {}
    for path in snakemake.input.curves:
        curves |= records.curves_from_table(tables.read(path, tables.CURVES))

    def parts():
        for point in points:
            curve = curves[grid.curve_key(point, snakemake.params.by_step)]
            scan = stick_slip(curve, point.mu0, point.dx0, snakemake.params.cycles)
            print(*point, scan.status, curve.message)
            yield records.scan_table(snakemake.wildcards.scan, point, scan)

    tables.write_parts(parts(), tables.SCANS, snakemake.output[0])

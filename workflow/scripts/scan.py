"""Move the clamp through one set of scans."""

from vibrissa.pipeline import jobs
from vibrissa.sticking.cycles import stick_slip
from vibrissa.study.codec import decode_grid, encode_values
from vibrissa.tables import records, schemas, store

with jobs.logged(snakemake.log[0]):
    points = list(decode_grid(snakemake.params.grid).points())
    curves = {}
    for path in snakemake.input.curves:
        curves |= records.curves_from_table(store.read(path, schemas.CURVES))

    def parts():
        for point in points:
            curve = curves[point.curve_key(snakemake.params.by_step)]
            scan = stick_slip(
                curve,
                point.mu0,
                point.dx0,
                snakemake.params.cycles,
                contact=snakemake.params.contact,
            )
            print(*encode_values(point), scan.status, curve.message, scan.message)
            yield records.scan_table(
                snakemake.wildcards.scan,
                point,
                scan,
                study=snakemake.params.study,
                method=curve.method,
            )

    store.write_parts(parts(), schemas.SCANS, snakemake.output[0])

"""Collect the grid points of all blocks, in one order, and check that each is there once."""

from pathlib import Path

from vibrissa.pipeline import jobs
from vibrissa.study.codec import decode_grid
from vibrissa.tables import schemas, store
from vibrissa.tables.added import refined_summary
from vibrissa.tables.collect import collect
from vibrissa.tables.completeness import POINT_ORDER, check_refined, checked_points

with jobs.logged(snakemake.log[0]):
    grids = {name: decode_grid(axes) for name, axes in snakemake.params.grids.items()}
    refined = frozenset(snakemake.params.refined)
    threads = snakemake.threads
    found = collect(snakemake.input.points, schemas.STICTION, POINT_ORDER, threads)
    schema = found.schema
    if refined:
        for path in snakemake.input.points:
            block = Path(path).name.partition(".")[0]
            check_refined(path, snakemake.params.refining[block])
        summary = refined_summary(snakemake.input.points)
        print(summary)
        schema = schema.with_metadata(schema.metadata | {store.REFINED: summary.encode()})
    store.write_parts(
        checked_points(found.parts, grids, refined),
        schema,
        snakemake.output[0],
        snakemake.params.study_file,
        found.rows,
        threads,
    )
    written = store.opened(snakemake.output[0], schemas.STICTION)
    counts = store.status_counts(written.iter_batches(columns=["status"]))
    print(", ".join(f"{count} {status}" for status, count in sorted(counts.items())))

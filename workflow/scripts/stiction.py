"""Collect the grid points of all blocks, in one order, and check that each is there once."""

from pathlib import Path

from vibrissa.pipeline import jobs
from vibrissa.study.codec import decode_grid, decode_refinement
from vibrissa.tables import schemas, store
from vibrissa.tables.added import check_refined, refined_summary
from vibrissa.tables.collect import collect
from vibrissa.tables.completeness import POINT_ORDER, checked_points

with jobs.logged(snakemake.log[0]):
    grids = {name: decode_grid(axes) for name, axes in snakemake.params.grids.items()}
    refinements = {
        name: decode_refinement(texts) for name, texts in snakemake.params.refinements.items()
    }
    threads = snakemake.threads
    found = collect(snakemake.input.points, schemas.STICTION, POINT_ORDER, threads)
    schema = found.schema
    if refinements:
        refining = snakemake.params.refining
        named = {Path(path).name.partition(".")[0]: path for path in snakemake.input.points}
        for block in refining:
            check_refined(named[block], refining[block])
        summary = refined_summary(named[block] for block in refining)
        print(summary)
        schema = schema.with_metadata(schema.metadata | {store.REFINED: summary.encode()})
    store.write_parts(
        checked_points(found.parts, grids, refinements),
        schema,
        snakemake.output[0],
        snakemake.params.study_file,
        found.rows,
        threads,
    )
    written = store.opened(snakemake.output[0], schemas.STICTION)
    counts = store.status_counts(written.iter_batches(columns=["status"]))
    print(", ".join(f"{count} {status}" for status, count in sorted(counts.items())))

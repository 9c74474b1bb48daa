"""Count the rows of the tables by their status; with strict, fail where rows failed."""

from pathlib import Path

from vibrissa.files import write_atomically
from vibrissa.pipeline import jobs
from vibrissa.tables import query
from vibrissa.tables.counts import counts_by_status, need_results, sentence

with jobs.logged(snakemake.log[0]):
    counts = counts_by_status(query.opened_tables(snakemake.input, snakemake.params.study_parts))
    with write_atomically(Path(snakemake.output[0])) as temporary:
        temporary.write_text(sentence(counts), encoding="utf-8")
    if snakemake.params.strict:
        need_results(counts)

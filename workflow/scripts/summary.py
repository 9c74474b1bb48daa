"""Count rows by status, and statements by verdict; fail if a figure, or a strict row, failed."""

from pathlib import Path

from vibrissa.files import write_atomically
from vibrissa.paper import ledger
from vibrissa.pipeline import jobs, outdated
from vibrissa.tables import accuracy, query
from vibrissa.tables.counts import counts_by_status, need_results, sentence

with jobs.logged(snakemake.log[0]):
    tables = query.opened_tables(snakemake.input, snakemake.params.study_parts)
    counts = counts_by_status(tables)
    text = sentence(counts)
    if "friction" in tables:
        read = query.frame(tables["friction"], [*accuracy.POINT, *accuracy.COLUMNS])
        text += "".join(f"{line}\n" for line in accuracy.sentences(read))
    if "claims" in tables:
        text += f"{ledger.summary(query.rows(tables['claims'], ['verdict']))}\n"
    # Checked before the file is there, which would end the study.
    outdated.need_drawn(Path(snakemake.output[0]).parent, snakemake.params.figures)
    if snakemake.params.strict:
        need_results(counts)
    with write_atomically(Path(snakemake.output[0])) as temporary:
        temporary.write_text(text, encoding="utf-8")

"""Judge the paper's statements by the study's tables."""

from pathlib import Path

from vibrissa.files import write_atomically
from vibrissa.outcomes import Solver
from vibrissa.paper import claims, evidence, ledger
from vibrissa.pipeline import jobs
from vibrissa.tables import query, store

with jobs.logged(snakemake.log[0]):
    tables = query.opened_tables(snakemake.input, snakemake.params.study_parts)
    table = ledger.claims_table(
        claims.CLAIMS,
        evidence.gather(tables, snakemake.params.names),
        study=snakemake.params.study,
        method=Solver(snakemake.params.method),
    )
    store.write(table, snakemake.output.table, snakemake.params.study_parts["claims"])
    with write_atomically(Path(snakemake.output.text)) as temporary:
        temporary.write_text(ledger.markdown(table), encoding="utf-8")
    print(ledger.summary(table))

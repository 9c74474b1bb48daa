"""Judge the paper's statements by the study's tables."""

from pathlib import Path

from vibrissa import claims, evidence, jobs, ledger, tables
from vibrissa.files import write_atomically

with jobs.logged(snakemake.log[0]):
    found = evidence.gather(
        *(
            tables.Stored(snakemake.input[name], getattr(tables, name.upper()))
            for name in ("stiction", "scans", "states")
        ),
        snakemake.params.names,
    )
    table = ledger.claims_table(claims.CLAIMS, found)
    tables.write(table, snakemake.output.table, snakemake.params.study_file)
    with write_atomically(Path(snakemake.output.text)) as temporary:
        temporary.write_text(ledger.markdown(table), encoding="utf-8")
    print(ledger.verdict_counts(table))

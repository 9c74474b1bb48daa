"""Put what the study found on one web page."""

from pathlib import Path

from vibrissa.files import write_atomically
from vibrissa.pipeline import jobs
from vibrissa.report.facts import environment
from vibrissa.report.page import Picture, Run, page
from vibrissa.tables import query
from vibrissa.tables.proofs import KEYS, read
from vibrissa.wording import figure_name

with jobs.logged(snakemake.log[0]):
    params = snakemake.params
    pictures = [
        Picture(name=figure_name(name), caption=caption, png=Path(path).read_bytes())
        for (name, caption), path in zip(
            params.captions.items(), snakemake.input.pictures, strict=True
        )
    ]
    run = Run(
        study_files=dict([params.study_file]),
        environment=environment(),
        benchmarks={
            rule: [Path(path).read_text() for path in paths if Path(path).is_file()]
            for rule, paths in params.benchmarks.items()
        },
        proofs=[proof for path in snakemake.input.proofs for proof in read(Path(path), KEYS)],
    )
    text = page(
        params.study, query.opened_tables(snakemake.input, params.study_parts), pictures, run
    )
    with write_atomically(Path(snakemake.output[0])) as temporary:
        temporary.write_text(text, encoding="utf-8")

"""Put what the study found on one web page."""

from pathlib import Path

from vibrissa.files import write_atomically
from vibrissa.pipeline import jobs
from vibrissa.report.facts import environment
from vibrissa.report.page import Picture, Run, page
from vibrissa.report.proofs import KEYS
from vibrissa.tables import query, schemas
from vibrissa.tables.proofs import read

with jobs.logged(snakemake.log[0]):
    names = ("stiction", "scans", "states", "comparisons", "claims")
    found = {
        name: query.opened(snakemake.input[name], schemas.TABLES[name])
        for name in names
        if snakemake.input[name]
    }
    pictures = [
        Picture(
            name=name,
            caption=caption,
            svg=Path(svg).read_bytes(),
            png=Path(png).read_bytes(),
        )
        for (name, caption), svg, png in zip(
            snakemake.params.captions.items(), snakemake.input.svg, snakemake.input.png, strict=True
        )
    ]
    run = Run(
        study_files=snakemake.params.study_files,
        environment=environment(),
        benchmarks={
            rule: [Path(path).read_text() for path in paths if Path(path).is_file()]
            for rule, paths in snakemake.params.benchmarks.items()
        },
        proofs=[proof for path in snakemake.input.proofs for proof in read(Path(path), KEYS)],
    )
    text = page(snakemake.params.study, found, pictures, run)
    with write_atomically(Path(snakemake.output[0])) as temporary:
        temporary.write_text(text, encoding="utf-8")
    print(f"{len(text.encode())} bytes")

"""Put what the study found on one web page."""

from pathlib import Path

from vibrissa import jobs, report, tables
from vibrissa.files import write_atomically

with jobs.logged(snakemake.log[0]):
    names = ("stiction", "scans", "states", "comparisons", "claims")
    found = {
        name: tables.Stored(snakemake.input[name], getattr(tables, name.upper()))
        for name in names
        if snakemake.input[name]
    }
    pictures = [
        report.Picture(name, caption, Path(svg).read_bytes(), Path(png).read_bytes())
        for (name, caption), svg, png in zip(
            snakemake.params.captions.items(), snakemake.input.svg, snakemake.input.png, strict=True
        )
    ]
    run = report.Run(
        study_files=snakemake.params.study_files,
        environment=report.environment(),
        benchmarks={
            rule: [Path(path).read_text() for path in paths if Path(path).is_file()]
            for rule, paths in snakemake.params.benchmarks.items()
        },
    )
    text = report.page(snakemake.params.study, found, pictures, run)
    with write_atomically(Path(snakemake.output[0])) as temporary:
        temporary.write_text(text, encoding="utf-8")
    print(f"{len(text.encode())} bytes")

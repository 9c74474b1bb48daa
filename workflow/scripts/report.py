"""Write the report of the study, one web page."""

from pathlib import Path

from vibrissa.files import write_atomically
from vibrissa.pipeline import jobs, outdated
from vibrissa.report.facts import environment
from vibrissa.report.page import About, Picture, page
from vibrissa.tables import query

with jobs.logged(snakemake.log[0]):
    params = snakemake.params
    pictures = [
        Picture(
            key=key,
            caption=figure["caption"],
            png=Path(path).read_bytes(),
            leads=figure["kind"] == "slip",
            selection=figure["selection"],
        )
        for (key, figure), path in zip(
            params.figures.items(), snakemake.input.pictures, strict=True
        )
    ]
    about = About(
        study=params.study,
        title=params.title,
        claims=params.claims,
        study_file=params.study_file,
        environment=environment(),
    )
    tables = query.opened_tables(snakemake.input, params.study_parts)
    with write_atomically(Path(snakemake.output[0])) as temporary:
        text = page(about, tables, pictures) + outdated.marked(params.mark)
        temporary.write_text(text, encoding="utf-8")

"""Draw all figures from the tables, and write down what each shows."""

from pathlib import Path

from vibrissa.figures import style
from vibrissa.figures.draw import draw
from vibrissa.files import write_atomically
from vibrissa.pipeline import jobs
from vibrissa.study.model import FIGURE_FORMATS
from vibrissa.tables import query

with jobs.logged(snakemake.log[0]):
    tables = query.opened_tables(snakemake.input, snakemake.params.study_parts)
    captions = Path(snakemake.output.captions)
    text = "# Figures\n"
    for name, figure in snakemake.params.figures.items():
        print(f"drawing {name}")
        drawn = draw(figure["kind"], tables[figure["table"]], figure["selection"])
        style.save(drawn, [captions.with_name(f"{name}.{suffix}") for suffix in FIGURE_FORMATS])
        text += f"\n**{name}.** {figure['caption']}".rstrip() + "\n"
    with write_atomically(captions) as temporary:
        temporary.write_text(text, encoding="utf-8")

"""Draw all figures from the tables, and write their captions."""

from pathlib import Path

from vibrissa.figures import style
from vibrissa.figures.draw import draw
from vibrissa.files import write_atomically
from vibrissa.pipeline import jobs
from vibrissa.tables import query
from vibrissa.wording import figure_name

with jobs.logged(snakemake.log[0]):
    params = snakemake.params
    tables = query.opened_tables(snakemake.input, params.study_parts)
    captions = Path(snakemake.output.captions)
    text = "# Figures\n"
    for name, figure in params.figures.items():
        print(f"drawing {name}")
        drawn = draw(
            figure["kind"],
            tables[figure["table"]],
            figure["selection"],
            script=figure["script"],
            look=figure,
        )
        endings = (*figure["formats"], "png")
        style.save(drawn, [captions.with_name(f"{name}.{ending}") for ending in endings])
        text += f"\n**{figure_name(name)}.** {figure['caption']}\n"
    with write_atomically(captions) as temporary:
        temporary.write_text(text, encoding="utf-8")

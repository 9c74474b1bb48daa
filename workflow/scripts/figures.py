"""Draw all figures from the tables, and write their captions."""

from pathlib import Path

from vibrissa.figures import style
from vibrissa.figures.draw import animate, draw
from vibrissa.files import write_atomically
from vibrissa.pipeline import jobs
from vibrissa.tables import query
from vibrissa.wording import figure_name

# Format of an animation; all other files have the figure itself.
ANIMATED = "apng"

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
        endings = [ending for ending in (*figure["formats"], "png") if ending != ANIMATED]
        paths = [captions.with_name(f"{name}.{ending}") for ending in endings]
        style.save(drawn, paths, figure_name(name), params.study)
        if ANIMATED in figure["formats"]:
            scans, film = tables[figure["table"]], captions.with_name(f"{name}.{ANIMATED}")
            animate(scans, figure["selection"], film)
        text += f"\n**{figure_name(name)}.** {figure['caption']}\n"
    with write_atomically(captions) as temporary:
        temporary.write_text(text, encoding="utf-8")

"""Draw figures from the tables, and write the captions of all figures."""

from pathlib import Path

from vibrissa.errors import TableError
from vibrissa.figures import style
from vibrissa.figures.draw import animate, draw
from vibrissa.files import write_atomically
from vibrissa.pipeline import jobs, outdated
from vibrissa.tables import query
from vibrissa.wording import figure_name

# Format of an animation; all other files have the figure itself.
ANIMATED = "apng"

with jobs.logged(snakemake.log[0]):
    params = snakemake.params
    tables = query.opened_tables(snakemake.input, params.study_parts)
    folder = Path(snakemake.output[0]).parent
    for name, figure in params.figures.items():
        print(f"drawing {name}")
        endings = [ending for ending in (*figure["formats"], "png") if ending != ANIMATED]
        paths = [folder / f"{name}.{ending}" for ending in endings]
        film = folder / f"{name}.{ANIMATED}" if ANIMATED in figure["formats"] else None
        failed = folder / f"{name}{outdated.FAILED}"
        failed.unlink(missing_ok=True)
        try:
            drawn = draw(
                figure["kind"],
                tables[figure["table"]],
                figure["selection"],
                script=figure["script"],
                look=figure,
            )
            style.save(drawn, paths, figure_name(name), params.study)
            if film:
                animate(tables[figure["table"]], figure["selection"], film)
        except (OSError, TableError):
            raise
        except Exception as error:
            # The other figures are drawn; rule `summary` ends the run with this error.
            print(f"error: {error}")
            failed.write_text(f"{error}\n", encoding="utf-8")
            style.save(style.message(f"{figure_name(name)} could not be drawn: {error}"), paths)
            if film:
                film.write_bytes(paths[-1].read_bytes())
    if params.captions is not None:
        text = "# Figures\n"
        for name, caption in params.captions.items():
            text += f"\n**{figure_name(name)}.** {caption}\n"
        with write_atomically(Path(snakemake.output.captions)) as temporary:
            temporary.write_text(f"{text}\n{outdated.marked(params.mark)}", encoding="utf-8")

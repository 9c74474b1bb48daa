"""What a study found, as one web page that needs nothing else: made of tables and texts alone.

The page is `page.html`, a template, with `page.css` and the explorer put into it.
"""

import base64
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import jinja2
from markupsafe import Markup

from vibrissa.explorer import page as explorer
from vibrissa.paper.ledger import verdict_counts
from vibrissa.report import facts, tables
from vibrissa.report.motion import motion
from vibrissa.report.proofs import Proved
from vibrissa.tables.frames import entries
from vibrissa.tables.proofs import Proof
from vibrissa.tables.query import Readable


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A figure with its caption.

    Attributes
    ----------
    name, caption : str
    png : bytes
    """

    name: str
    caption: str
    png: bytes

    @property
    def source(self) -> str:
        """The drawing as a data URI."""
        return f"data:image/png;base64,{base64.b64encode(self.png).decode()}"


@dataclass(frozen=True, kw_only=True)
class Run:
    """What was run, and on what: the part of the page that does not follow from the tables.

    Attributes
    ----------
    study_files : mapping of str
        Text of each study file by its name.
    environment : mapping of str
        Versions of the software and what is to be said of the machine, by name.
    benchmarks : mapping
        Texts of Snakemake's benchmark files of each rule.
    proofs : sequence of Proof
        What is proved of the tables' numbers.
    """

    study_files: Mapping[str, str]
    environment: Mapping[str, str]
    benchmarks: Mapping[str, Sequence[str]]
    proofs: Sequence[Proof] = ()


def page(study: str, found: Mapping[str, Readable], pictures: Iterable[Picture], run: Run) -> str:
    """Write the page.

    Parameters
    ----------
    study : str
        The study's name.
    found : mapping of pyarrow.Table or Dataset
        The study's tables by name: ``stiction`` and, where there are any, ``scans``, ``states``,
        ``comparisons`` and ``claims``. Of one in a file as much is held as the page shows.
    pictures : iterable of Picture
    run : Run

    Returns
    -------
    str
        HTML that refers to nothing outside itself.
    """
    here = Path(__file__)
    claims = facts.claim_rows(found["claims"]) if "claims" in found else []
    proved = Proved(run.proofs)
    return _template(here.with_suffix(".html")).render(
        study=study,
        style=Markup(here.with_suffix(".css").read_text(encoding="utf-8")),
        summary=facts.summary(found) | proved.summary(),
        troubles=facts.troubles(found),
        moves=motion(found),
        explorer=explorer,
        pictures=list(pictures),
        verdicts=verdict_counts(row["verdict"] for row in claims),
        claims=claims,
        tables=tables.sections(found, proved),
        dictionary={name: entries(table.schema) for name, table in found.items()},
        origins=[facts.origin(name, table) for name, table in found.items()],
        job_times=facts.job_times(run.benchmarks),
        run=run,
    )


def _template(path: Path) -> jinja2.Template:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(path.parent),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":")}
    return environment.get_template(path.name)

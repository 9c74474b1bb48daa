"""The report of a study: one web page made from its tables, figures and texts."""

import base64
import re
import struct
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

from markupsafe import Markup
from PIL import Image

from vibrissa import paper
from vibrissa.explorer import page as explorer
from vibrissa.paper.evidence import gather
from vibrissa.paper.ledger import Verdict, verdict_counts
from vibrissa.paper.reproduction import reproduced
from vibrissa.report import facts, tables
from vibrissa.report.motion import motion
from vibrissa.report.spelling import with_symbols
from vibrissa.study.figures import PARTS
from vibrissa.tables.query import Readable
from vibrissa.wording import figure_name

FOLDER = Path(__file__).parent
# Resolution of the figures' PNG files, and their enlargement on the page: 7 pt become 13 pixels.
DOTS_PER_INCH, ENLARGED = 300, 1.4
# Width of a phone's screen (CSS pixels).
PHONE = 500


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A figure with its caption, and the rows that it shows; some stand at the head of the page."""

    key: str
    caption: str
    png: bytes
    leads: bool = False
    selection: Mapping[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name, such as ``Figure 4a``."""
        return figure_name(self.key)

    @property
    def width(self) -> int:
        """Width on the page (CSS pixels): that of the printed figure, enlarged by `ENLARGED`."""
        (pixels,) = struct.unpack(">I", self.png[16:20])
        return round(ENLARGED * 96 * pixels / DOTS_PER_INCH)

    @property
    def is_wide(self) -> bool:
        """Whether the figure is wider than a phone's screen: there it is cut up, or scrolls."""
        return self.width > PHONE

    @property
    def parts(self) -> str:
        """Parts of the drawing that a phone shows below each other, as JSON: `figures.parts`."""
        return str(Image.open(BytesIO(self.png)).info.get(PARTS, ""))

    @property
    def source(self) -> str:
        """The drawing as a data URI."""
        return f"data:image/png;base64,{base64.b64encode(self.png).decode()}"


@dataclass(frozen=True, kw_only=True)
class About:
    """Data of the report other than tables and figures.

    Attributes
    ----------
    claims : mapping of str
        Value of the key `claims` in the study file; empty if the file has no such key.
    study_file : tuple of str
        Name and text of the study file.
    """

    study: str
    title: str
    claims: Mapping[str, str]
    study_file: tuple[str, str]
    environment: Mapping[str, str]


def page(about: About, found: Mapping[str, Readable], pictures: Sequence[Picture]) -> str:
    """Return the page as HTML without external references.

    `found` has the tables by name: ``stiction`` and, if the study has them, ``scans``, ``states``,
    ``comparisons`` and ``claims``.
    """
    claims = facts.claim_rows(found["claims"]) if "claims" in found else []
    parts = reproduced(gather(found, about.claims)) if about.claims else []
    open_verdicts = (Verdict.CONTRADICTED, Verdict.AMBIGUOUS)
    presets, omitted = motion(found, {picture.name: picture.selection for picture in pictures})
    environment = explorer.environment(FOLDER)
    environment.filters["anchor"] = facts.anchor
    environment.filters["symbols"] = with_symbols
    return environment.get_template("page.html").render(
        about=about,
        title=paper.TITLE if about.claims else about.title,
        citation=paper.CITATION if about.claims else "",
        style=Markup((FOLDER / "page.css").read_text(encoding="utf-8")),
        program=Markup((FOLDER / "page.js").read_text(encoding="utf-8")),
        results=facts.results(found),
        summary=facts.summary(found),
        troubles=facts.troubles(found),
        reproduced=parts,
        counts=lambda names: Counter(
            Verdict(row["verdict"]) for row in claims if row["claim"] in names
        ),
        leading=[picture for picture in pictures if picture.leads],
        pictures=[picture for picture in shown(pictures) if not picture.leads],
        places={picture.name: picture.key for picture in pictures},
        verdicts=verdict_counts(row["verdict"] for row in claims),
        open=sorted(
            (row for row in claims if row["verdict"] in open_verdicts),
            key=lambda row: open_verdicts.index(row["verdict"]),
        ),
        settled=[row for row in claims if row["verdict"] not in open_verdicts],
        presets=presets,
        omitted=omitted,
        explorer=explorer,
        tables=tables.sections(found),
        origins=facts.origins(found),
    )


def shown(pictures: Sequence[Picture]) -> list[Picture]:
    """Leave out single panels, such as Figure 4a, of figures that are shown whole."""
    names = {picture.name for picture in pictures}
    parts = {
        name for name in names if re.fullmatch(r"Figure \d+[a-z]", name) and name[:-1] in names
    }
    return [picture for picture in pictures if picture.name not in parts]

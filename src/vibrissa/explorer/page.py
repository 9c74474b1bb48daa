"""The explorer as a separate page, and as a part of other pages."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import jinja2
import yaml
from markupsafe import Markup

from vibrissa.explorer.modules import FOLDER, bundle

# The range of each field of the page, as in view/settings.js.
RANGES = {
    "theta": (1.0, 20.0),
    "eta": (0.3, 0.99),
    "mu0": (0.02, 2.0),
    "dx0": (0.0001, 0.05),
    "ratio": (0.05, 1.0),
    "beta": (-20.0, 20.0),
    "compliance": (0.0, 0.5),
    "kappa0": (-1.0, 1.0),
    "kappa1": (-1.0, 1.0),
    "stiffening": (-0.9, 10.0),
    "bore": (0.0, 0.95),
    "delta": (-6.0, 6.0),
    "amplitude": (0.0, 0.01),
    "wavelength": (0.002, 0.5),
}


@dataclass(frozen=True, kw_only=True)
class RecordedMotion:
    """A recording to draw beside the computed loads.

    It has the clamp's position `clamp` (L), fx and fy (E·I0/L²), and m (E·I0/L).
    """

    name: str
    clamp: Sequence[float]
    fx: Sequence[float]
    fy: Sequence[float]
    m: Sequence[float]


@dataclass(frozen=True, kw_only=True)
class Preset:
    """Settings that a user can choose by name, with a note that the page then shows.

    Attributes
    ----------
    settings : mapping
        Values of the page's fields by key (`view/settings.js`); other fields keep their values.
    clamp : float
        Position to which the clamp moves (L).
    play : bool
        Whether the clamp then moves on by itself.
    """

    name: str
    note: str = ""
    settings: Mapping[str, float | str]
    clamp: float = 0.0
    play: bool = False
    recording: RecordedMotion | None = None


_KNOWN = yaml.safe_load((FOLDER / "presets.yaml").read_text(encoding="utf-8"))
# Settings of mounting and surface for a rod that is mounted as in the paper, on a plane.
IDEAL: Mapping[str, float] = _KNOWN["ideal"]


def _presets(kind: str) -> tuple[Preset, ...]:
    """Presets of one kind from the file; the paper's settings complete each preset."""
    rows = [row | {"settings": _KNOWN["common"] | IDEAL | row["settings"]} for row in _KNOWN[kind]]
    return tuple(Preset(**row) for row in rows)


PAPER = _presets("paper")
MOUNTED = _presets("mounted")
WAVES = _presets("waves")


def fits(settings: Mapping[str, float | str]) -> bool:
    """Whether the fields of the page allow all values of these settings."""
    return all(
        low <= float(settings.get(name, low)) <= high for name, (low, high) in RANGES.items()
    )


def fragment(presets: Sequence[Preset]) -> Markup:
    """Render the explorer as a part of a page; the page also needs `style` and `program`."""
    rows = [asdict(preset) for preset in presets]
    return Markup(environment(FOLDER).get_template("explorer.html").render(presets=rows))


def style() -> Markup:
    """Style sheet of the explorer; it affects no other part of a page."""
    return Markup((FOLDER / "explorer.css").read_text(encoding="utf-8"))


def program() -> Markup:
    """JavaScript of the explorer, in a scope of its own."""
    return Markup(f'(() => {{\n"use strict";\n{bundle("view/explorer.js")}}})();')


def page(home: str = "") -> str:
    """Render the explorer as a separate page, with links to the site at `home`, if given."""
    return (
        environment(FOLDER)
        .get_template("page.html")
        .render(
            home=home,
            explorer=fragment((*PAPER, *MOUNTED, *WAVES)),
            style=style(),
            program=program(),
        )
    )


def environment(folder: Path) -> jinja2.Environment:
    """Return a Jinja environment for the templates in a folder."""
    made = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.policies["json.dumps_kwargs"] = {"separators": (",", ":")}
    return made

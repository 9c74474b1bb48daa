"""The explorer as a page of its own, and as a part of other pages."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import jinja2
from markupsafe import Markup

from vibrissa.explorer.modules import bundle

FOLDER = Path(__file__).parent


# The range of each field of the page.
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
    "delta": (-6.0, 6.0),
}


@dataclass(frozen=True, kw_only=True)
class Recording:
    """Readings that are drawn beside those of the page.

    Attributes
    ----------
    name : str
    clamp, fx, fy, m : sequence of float
        Position of the clamp (L), its reactions (E·I0/L²) and moment (E·I0/L).
    """

    name: str
    clamp: Sequence[float]
    fx: Sequence[float]
    fy: Sequence[float]
    m: Sequence[float]


@dataclass(frozen=True, kw_only=True)
class Preset:
    """Settings that a user can choose by name.

    Attributes
    ----------
    name : str
    note : str
        What the page then says.
    settings : mapping
        Values of the page's fields by their keys (`view/settings.js`); the others stay.
    clamp : float
        Where the clamp is moved (L).
    play : bool
        Whether the clamp then moves on by itself.
    recording : Recording, optional
    """

    name: str
    note: str = ""
    settings: Mapping[str, float | str]
    clamp: float = 0.0
    play: bool = False
    recording: Recording | None = None


# A rod that is mounted as in the paper.
IDEAL = dict.fromkeys(("beta", "compliance", "kappa0", "kappa1", "delta"), 0.0)


def _paper(theta: float, mu0: float) -> dict[str, float | str]:
    """Give the paper's settings: tip contact, free slips, a round rod, the ideal mounting."""
    words = {"contact": "point", "section": "round", "law": "free"}
    return {"theta": theta, "mu0": mu0, "eta": 0.85, "dx0": 0.001} | words | IDEAL


# The figures of the paper, as config.yaml has them.
PAPER = (
    Preset(
        name="Figure 3: one period",
        note="One period of sticking at θ = 2, μ0 = 0.4, in steps of 0.001.",
        settings=_paper(2, 0.4),
        clamp=0.052,
    ),
    *(
        Preset(
            name=f"Figure {figure}: play",
            note=f"Stick and slip at θ = {theta}, μ0 = {mu0}, in steps of 0.001.",
            settings=_paper(theta, mu0),
            play=True,
        )
        for figure, theta, mu0 in (
            ("4a", 1, 0.3),
            ("4b", 2, 0.3),
            ("4c", 3, 0.3),
            ("5a", 1, 0.4),
            ("5b", 2, 0.4),
            ("5c", 3, 0.4),
        )
    ),
    Preset(
        name="Figure 6: move θ",
        note="Move θ from 1 to 3 and watch x0,max.",
        settings=_paper(1, 0.3),
    ),
    Preset(
        name="Figure 7: move μ0",
        note="Move μ0 from 0.1 to 0.5 and watch x0,max; above μ_lock the tip locks.",
        settings=_paper(2, 0.1),
    ),
    Preset(
        name="Figure 8: a tip in the surface",
        note="With the tip at 0.15 ahead of the clamp, the rod passes through the surface.",
        settings=_paper(1, 2) | {"eta": 0.55},
        clamp=0.572,
    ),
)


def _mounted(name: str, note: str, **settings: float | str) -> Preset:
    """Make a preset of a rod that is mounted otherwise than in the paper."""
    return Preset(
        name=f"Mounting: {name}", note=note, settings=_paper(2, 0.4) | settings, play=True
    )


# The deviations of docs/mounting.md, each by itself.
MOUNTED = (
    _mounted("a clamp that leans back", "The tip locks earlier and slips later.", beta=5),
    _mounted("a clamp that yields", "A tapered rod slips later.", compliance=0.1),
    _mounted(
        "a curved whisker",
        "A strongly tapered rod that is curved away from the surface, in line contact.",
        theta=15,
        mu0=0.3,
        dx0=0.002,
        contact="line",
        kappa0=-0.3,
    ),
    _mounted(
        "an oblique stage",
        "The clamp comes nearer to the surface, so that each period is another one.",
        dx0=0.002,
        delta=3,
    ),
)


def fits(settings: Mapping[str, float | str]) -> bool:
    """Say whether the page's fields allow all of some settings."""
    return all(
        low <= float(settings.get(name, low)) <= high for name, (low, high) in RANGES.items()
    )


def fragment(presets: Sequence[Preset]) -> Markup:
    """Write the explorer as a part of a page, which also needs `style` and `program`.

    Parameters
    ----------
    presets : sequence of Preset

    Returns
    -------
    Markup
    """
    rows = [asdict(preset) for preset in presets]
    return Markup(_template("explorer.html").render(presets=rows))


def style() -> Markup:
    """Style sheet of the explorer; it touches nothing else of a page."""
    return Markup((FOLDER / "explorer.css").read_text(encoding="utf-8"))


def program() -> Markup:
    """Program of the explorer, in a scope of its own."""
    return Markup(f'(() => {{\n"use strict";\n{bundle("view/explorer.js")}}})();')


def page(home: str = "") -> str:
    """Write the explorer as a page of its own.

    Parameters
    ----------
    home : str, optional
        Address of the site that the page is part of; the page links there.

    Returns
    -------
    str
        HTML that needs nothing outside itself.
    """
    return _template("page.html").render(
        home=home, explorer=fragment((*PAPER, *MOUNTED)), style=style(), program=program()
    )


def _template(name: str) -> jinja2.Template:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(FOLDER),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":")}
    return environment.get_template(name)

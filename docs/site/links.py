"""Sphinx extension: links out of docs/, pictures of the gallery, numbers of equations, search.

In the repository a page links to files outside `docs/`, and refers to an equation by its number,
as in (E1). On the site a link to a notebook leads to its page, a link to another file becomes plain
text, and the number becomes a link to the equation.
"""

import re

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.transforms.post_transforms import SphinxPostTransform

OUTSIDE = re.compile(r"\[([^\]]+)\]\(\.\./([^)#\s]*)(#[^)\s]*)?\)")
NOTEBOOK = re.compile(r"\(\.\./examples/(\w+\.ipynb)\)")
SAVED = re.compile(r"plt\.savefig\(\"(.*)\"\)\n```\n")
EQUATION = re.compile(r"(?<=\()([EMD]\d+[a-d]?)(?=\))|(?<=(?<!paper )[Ee]quation \()(\d)(?=\))")
# The page of an equation, by the first character of its number.
PAGES = {
    **dict.fromkeys("12378", "model"),
    **dict.fromkeys("E569", "numerics"),
    "M": "mounting",
    "D": "lateral",
}

# Terms that a search finds first, by the page and the heading that explain them.
TERMS = {
    ("index", "How to cite"): "cite, citation, authors, DOI, license, BibTeX",
    ("install", "Install"): "conda, Python version, Windows",
    (
        "reproduce",
        "Reproduce the paper",
    ): "CORES, CORES=n, logs, results/<study>/logs/, log of a job",
    ("reproduce", "Archive a study"): "archive, Zenodo, RO-Crate, publication",
    ("reproduce", "Values of θ, μ0, η and Δx0"): "theta grid, θ grid, theta values",
    ("study", "Resume and extend"): "resume, continue, interrupted run, chunk",
    ("study", "A figure of your own"): "new kind of figure, figure of your own, script",
    ("study", "Point or line contact"): "point contact, line contact",
    ("cluster", "On a cluster"): "cluster, SLURM, PBS, queue, job, partition, slurm_partition",
    ("open", "What the paper left open"): "open questions, which rod, wave, experiment",
    ("ci", "Results in CI"): "CI, continuous integration, GitHub Actions",
    ("python", "Python"): "friction from travel, friction_from_travel, solve_onset",
    ("python", "Gallery"): "gallery, examples",
    (
        "friction",
        "Friction from your recording",
    ): "recording, own recording, friction from recording, measurement, friction coefficient",
    ("friction", "Your file"): "tare, zero, import, CSV",
    ("friction", "Tolerances"): "tolerance, uncertainty, confidence interval",
    ("model", "Self-locking"): "self-locking, mu_lock, μ_lock",
    ("model", "Not covered"): "hollow, gravity, limits, limits of the model",
    ("model", "Line contact"): "flat segment, s_c",
    ("lateral", "Lateral buckling"): "swings_aside, x0_trail",
    ("glossary", "Symbols"): "theta, θ, mu0, μ0, eta, η, dx0, Δx0, taper factor, step, x0,max",
    ("glossary", "Status"): "status, out_of_reach, failed, ends_by, lock",
    ("study_file", "Grids"): "grid, axis, range",
    ("study_file", "Figures"): "figure, kind of figure",
    ("tables", "Reading a table"): "R, tables in R, pandas, Polars, DuckDB, Parquet",
    ("tables", "State of the rod"): "reaction_fx, reaction_fy, reaction_m, load on the clamp",
    ("tables", "stiction"): "x0_max, x0_slip, penetrates, column",
    ("trust", "Accuracy"): "accuracy, error, residual, precision",
}


def keep_inside(app: Sphinx, page: str, source: list[str]) -> None:
    """Change the links of a page out of docs/; pages in docs/made are not changed."""
    if not page.startswith("made/"):
        source[0] = NOTEBOOK.sub(r"(made/notebooks/\1)", source[0])
        source[0] = OUTSIDE.sub(r"\1", source[0])


def with_pictures(app: Sphinx, page: str, source: list[str]) -> None:
    """Insert below each block of the gallery the picture that the block saves."""
    if page == "python":
        source[0] = SAVED.sub(r"\g<0>\n![\g<1>](made/gallery/\g<1>)\n", source[0])


def with_terms(app: Sphinx, page: str, source: list[str]) -> None:
    """Insert the terms of `TERMS` as index entries before their heading."""
    for (place, heading), terms in TERMS.items():
        if place == page:
            # A search lists main entries, marked by !, before all other results. An entry without
            # "single:" would end at a comma, as in x0,max.
            entries = [f"```{{index}} !single: {term}\n```\n\n" for term in terms.split(", ")]
            title = re.compile(rf"^(#+ {heading})$", re.MULTILINE)
            source[0] = title.sub(rf"{''.join(entries)}\1", source[0], count=1)


class NumbersOfEquations(SphinxPostTransform):
    """Replace the numbers of equations by links to the equations."""

    default_priority = 700

    def run(self, **_: object) -> None:
        """Replace the numbers on a page."""
        for text in list(self.document.findall(nodes.Text)):
            if isinstance(text.parent, (nodes.reference, nodes.math, nodes.math_block)):
                continue
            parts: list[nodes.Node] = []
            end = 0
            for match in EQUATION.finditer(text):
                parts += [nodes.Text(text[end : match.start()]), self.link(match[0])]
                end = match.end()
            if parts:
                text.parent.replace(text, [*parts, nodes.Text(text[end:])])

    def link(self, number: str) -> nodes.reference:
        """Make a link to an equation."""
        uri = self.app.builder.get_relative_uri(self.env.docname, PAGES[number[0]])
        return nodes.reference("", number, refuri=f"{uri}#equation-{number.lower()}", internal=True)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the functions and the transform."""
    app.connect("source-read", keep_inside)
    app.connect("source-read", with_pictures)
    app.connect("source-read", with_terms)
    app.add_post_transform(NumbersOfEquations)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

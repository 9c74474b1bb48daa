"""Sphinx extension: links out of the folder of the pages, names of code, numbers of equations.

A page is read in the repository as well. There it links to files beside `docs/`, names code as
`mechanics.taper.stiffness`, and an equation as (E1). On the site a notebook is a page, another file
is its name alone, the name of code leads to its reference, and a number to its equation.
"""

import re
from pkgutil import iter_modules

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.transforms.post_transforms import SphinxPostTransform

import vibrissa

OUTSIDE = re.compile(r"\[([^\]]+)\]\(\.\./([^)#\s]*)(#[^)\s]*)?\)")
NOTEBOOK = re.compile(r"examples/(\w+)\.ipynb")
SAVED = re.compile(r"plt\.savefig\(\"(.*)\"\)\n```\n")
DIAGRAM = re.compile(r"```mermaid\n.*?```\n", re.DOTALL)
# Equations are counted with a letter for each page, and without one in the model.
EQUATION = re.compile(r"(?<=\()([EMD]\d+[a-d]?)(?=\))|(?<=(?<!paper )[Ee]quation \()(\d)(?=\))")
PAGES = {"E": "model", "M": "mounting", "D": "aside"}
PACKAGES = "|".join(module.name for module in iter_modules(vibrissa.__path__))
CODE = re.compile(rf"(?:vibrissa\.)?((?:{PACKAGES})\.[\w.]+)(\(\))?")


def within(match: re.Match[str]) -> str:
    """Give what takes the place of a link that leads out of the folder."""
    text, target, _ = match.groups()
    if notebook := NOTEBOOK.fullmatch(target):
        return f"[{text}](made/notebooks/{notebook[1]}.ipynb)"
    return text


def keep_inside(app: Sphinx, page: str, source: list[str]) -> None:
    """Change the links of a page that lead out of the folder."""
    source[0] = OUTSIDE.sub(within, source[0])


def with_pictures(app: Sphinx, page: str, source: list[str]) -> None:
    """Show below each block of the gallery the picture that it saves."""
    if page == "gallery":
        source[0] = SAVED.sub(r"\g<0>\n![\g<1>](made/gallery/\g<1>)\n", source[0])
    source[0] = DIAGRAM.sub("![The packages, and what they import](made/packages.svg)\n", source[0])


class NamesOfCode(SphinxPostTransform):
    """Make names of code links to their reference, where it has one."""

    default_priority = 5  # before links are resolved, at 10

    def run(self, **_: object) -> None:
        """Change the page."""
        for literal in list(self.document.findall(nodes.literal)):
            named = CODE.fullmatch(literal.astext())
            if named is None or isinstance(
                literal.parent, (nodes.reference, addnodes.pending_xref)
            ):
                continue
            link = addnodes.pending_xref(
                "",
                literal.deepcopy(),
                refdomain="py",
                reftype="obj",
                reftarget=f"vibrissa.{named[1]}",
                refdoc=self.env.docname,
                refwarn=False,
            )
            literal.replace_self(link)


class NumbersOfEquations(SphinxPostTransform):
    """Make numbers of equations links to them."""

    default_priority = 700

    def run(self, **_: object) -> None:
        """Change the page."""
        for text in list(self.document.findall(nodes.Text)):
            if isinstance(text.parent, (nodes.reference, nodes.math, nodes.math_block)):
                continue
            parts: list[nodes.Node] = []
            end = 0
            for match in EQUATION.finditer(text):
                number = match[0]
                parts += [nodes.Text(text[end : match.start()]), self.link(number)]
                end = match.end()
            if parts:
                text.parent.replace(text, [*parts, nodes.Text(text[end:])])

    def link(self, number: str) -> nodes.reference:
        """Make a link to an equation."""
        page = PAGES.get(number[0], "model")
        uri = self.app.builder.get_relative_uri(self.env.docname, page)
        return nodes.reference("", number, refuri=f"{uri}#equation-{number.lower()}", internal=True)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register what changes links."""
    app.connect("source-read", keep_inside)
    app.connect("source-read", with_pictures)
    app.add_post_transform(NamesOfCode)
    app.add_post_transform(NumbersOfEquations)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

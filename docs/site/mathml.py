"""Sphinx extension: equations as MathML, which a browser shows without script or font."""

import re

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

# Beginning of the number of an equation, which is shown at the right.
TAG = r"\tag{"

# Where a line may end on a narrow screen: MathML itself has no line breaks.
BETWEEN = re.compile(r"\\q?quad(?![a-zA-Z])")
# A function before its argument, as in cos α.
APPLIED = re.compile(r"(<mi>(?:sin|cos|tan|det)</mi>)(?=<m[ins])")


def mathml(latex: str, display: str) -> str:
    """Translate an equation, with a space between a function and its argument."""
    return APPLIED.sub(r'\1<mspace width="0.167em"/>', convert(latex, display=display))


def without_tag(latex: str) -> tuple[str, str]:
    r"""Split an equation from its number ``\tag{...}``; the number is empty if it has none."""
    equation, tagged, rest = latex.partition(TAG)
    number, _, after = rest.partition("}")
    return equation + after, number if tagged else ""


def lines(latex: str) -> list[str]:
    r"""Split an equation at each ``\quad``, unless it has several rows."""
    return [latex] if r"\begin" in latex else [part.strip() for part in BETWEEN.split(latex)]


def visit_inline(self: HTML5Translator, node: nodes.math) -> None:
    """Write an equation in a line of text."""
    self.body.append(mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def visit_block(self: HTML5Translator, node: nodes.math_block) -> None:
    """Write a displayed equation with its number, which can be the target of a link."""
    equation, number = without_tag(node.astext())
    self.body.append(self.starttag(node, "div", CLASS="equation"))
    self.body.append('<div class="parts">')
    self.body += [mathml(part, "block") for part in lines(equation)]
    self.body.append("</div>")
    if number:
        place = f"equation-{number.lower()}"
        self.body.append(f'<a class="number" id="{place}" href="#{place}">({number})</a>')
    self.body.append("</div>\n")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}

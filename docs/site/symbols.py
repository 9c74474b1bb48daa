"""Sphinx extension: symbols in the text look as in the equations, with italics and subscripts.

The pages have plain text, such as x0,max and μ0, which can be read and searched everywhere. Only
the finished HTML is changed, not what the search finds.
"""

import re
from typing import Any

from sphinx.application import Sphinx

# Elements whose text stays as it is, and parts of HTML: tags, and text between them.
KEPT = ("code", "pre", "math", "script", "style", "svg", "kbd")
PART = re.compile(r"(<[^>]*>)")
SYMBOL = re.compile(
    r"(?<![\w.@#&_])(?:"
    r"(?P<stiffness>E·I0)(?P<per>/L²|/L)?(?!\w)"
    r"|(?P<place>Δ?x)(?P<which>[01](?:,(?:slip|max|init))?)(?![\w,]\w)(?!\w)"
    r"|(?P<load>f)(?P<along>[xy])(?!\w)"
    r"|(?P<lock>μ|s)_(?P<name>lock|c)(?!\w)"
    r"|(?P<letter>[μκφωdIA])(?P<digit>[01k])(?!\w)"
    r"|(?P<greek>[αβγδζηθκλμνρτφψω])(?!\w)"
    r")"
)


def _shown(match: re.Match[str]) -> str:
    found = match.groupdict()
    if found["stiffness"]:
        per = (found["per"] or "").replace("L", "<i>L</i>")
        return f"<i>E</i>·<i>I</i><sub>0</sub>{per}"
    if found["greek"]:
        return f"<i>{found['greek']}</i>"
    pairs = (("place", "which"), ("load", "along"), ("lock", "name"), ("letter", "digit"))
    letter, below = next((found[one], found[other]) for one, other in pairs if found[one])
    return f"<i>{letter}</i><sub>{below}</sub>"


def with_symbols(html: str) -> str:
    """Write the symbols in a text of HTML with italics and subscripts."""
    inside, parts = 0, []
    for part in PART.split(html):
        if part.startswith("<"):
            name = re.match(r"</?(\w*)", part)
            if name and name[1] in KEPT:
                inside += -1 if part.startswith("</") else 1
            parts.append(part)
        else:
            parts.append(part if inside else SYMBOL.sub(_shown, part))
    return "".join(parts)


def show(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: object) -> None:
    """Change the text of a page."""
    if "body" in context and not page.startswith("made/"):
        context["body"] = with_symbols(str(context["body"]))


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the function."""
    app.connect("html-page-context", show)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

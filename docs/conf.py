"""How `make docs` builds the site of these pages. Sphinx reads this file."""

import re
import sys
from pathlib import Path
from typing import Any

from pygments.lexers.python import PythonLexer
from sphinx.application import Sphinx

import vibrissa

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS / "site"))

# A vertical bar outside of code.
BAR = re.compile(r"(?<!`)\|(?=[^`]*(?:``[^`]*``[^`]*)*$)")

import made  # noqa: E402

made.make(DOCS / "made")

project = "Vibrissa"
author = "Vibrissa developers"
copyright = f"2026, {author}"
version = release = vibrissa.__version__

extensions = [
    "myst_nb",  # Markdown, and notebooks as pages
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_copybutton",
    # In docs/site: equations as MathML and symbols like them, links out of docs/ and to equations,
    # excerpts of a search.
    "mathml",
    "symbols",
    "links",
    "excerpts",
]
exclude_patterns = ["_build", "site", "made/explorer"]

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "attrs_inline"]
myst_heading_anchors = 4
# The notebooks of the examples keep their outputs, which a test compares. `made` runs the gallery.
nb_execution_mode = "off"
autosummary_generate = False

autodoc_typehints = "none"  # the sections of numpydoc state the types
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

html_theme = "furo"
html_title = "Vibrissa"
html_static_path = ["site/static"]
# Copied as it is: the explorer is a page of its own.
html_extra_path = ["made/explorer"]
templates_path = ["site/templates"]
# The sidebar of furo, with a link to the explorer above the pages.
html_sidebars = {
    "**": [
        *("sidebar/brand.html", "sidebar/search.html", "sidebar/scroll-start.html"),
        *("explorer.html", "sidebar/navigation.html", "sidebar/scroll-end.html"),
    ]
}
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_copy_source = False
html_show_sourcelink = False
html_math_renderer = "mathml"
copybutton_prompt_text = r"\$ |>>> "
copybutton_prompt_is_regexp = True


def escape_bars(
    app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]
) -> None:
    """Escape the bars in a docstring, as in |tan α|, which Sphinx would read as a substitution."""
    lines[:] = [BAR.sub(r"\\|", line) for line in lines]


def without_aliases(
    app: Sphinx, what: str, name: str, thing: object, skip: bool, options: object
) -> bool | None:
    """Leave out the fields of named tuples, as the docstring of the class describes them."""
    return True if type(thing).__name__ == "_tuplegetter" else None


def with_levels(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: object
) -> None:
    """Give the headings of the sidebar their level, which screen readers need."""
    tree = str(context.get("furo_navigation_tree", ""))
    context["furo_navigation_tree"] = tree.replace(
        'role="heading"', 'role="heading" aria-level="2"'
    )


def setup(app: Sphinx) -> None:
    """Highlight Snakefiles as Python, and register the functions above."""
    app.add_lexer("snakemake", PythonLexer)
    app.connect("autodoc-process-docstring", escape_bars)
    app.connect("autodoc-skip-member", without_aliases)
    # After the theme has made the sidebar.
    app.connect("html-page-context", with_levels, priority=900)

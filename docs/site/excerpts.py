"""Sphinx extension: a search that shows excerpts in a site that is opened from files, too.

The search of Sphinx fetches each page that it has found, which browsers refuse for files. Therefore
the page of the search loads the texts of all pages as a script, and takes them from there.
"""

import json
from html import escape
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

SCRIPT = "excerpts.js"
PROGRAM = """
if (location.protocol === "file:") {
  window.fetch = async (address) => {
    const name = decodeURI(new URL(address, location).pathname);
    const page = Object.keys(PAGES).find((key) => name.endsWith("/" + key));
    return new Response(`<div role="main">${PAGES[page] ?? ""}</div>`);
  };
}
"""


def load(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: object) -> None:
    """Let the page of the search load the script."""
    if page == "search":
        app.add_js_file(SCRIPT)


def sections(node: nodes.Element) -> str:
    """Write the texts of a page as HTML that keeps its sections, to which results lead."""
    parts = []
    for child in node.children:
        if isinstance(child, nodes.section):
            # A section has several places if index entries lead to it, too.
            opened = "".join(f'<section id="{place}">' for place in child["ids"])
            parts.append(opened + sections(child) + "</section>" * len(child["ids"]))
        else:
            parts.append(f"{escape(child.astext())}\n")
    return "".join(parts)


def write(app: Sphinx, error: Exception | None) -> None:
    """Write the script with the texts of all pages."""
    if error is None and app.builder.format == "html":
        suffix = app.builder.out_suffix  # type: ignore[attr-defined]
        texts = {
            f"{name}{suffix}": sections(app.env.get_doctree(name))
            for name in sorted(app.env.found_docs)
        }
        script = f"const PAGES = {json.dumps(texts)};{PROGRAM}"
        Path(app.outdir, "_static", SCRIPT).write_text(script, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the functions."""
    app.connect("html-page-context", load)
    app.connect("build-finished", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

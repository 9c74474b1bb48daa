"""The pages, and the code in them."""

import re
import shlex

from runs import ROOT

PAGES = {
    str(path.relative_to(ROOT)): path.read_text(encoding="utf-8")
    for pattern in ("*.md", "results/*.md", "config/*.md", "docs/*.md")
    for path in sorted(ROOT.glob(pattern))
}


def blocks(language, pages=PAGES):
    """Name of the page and text of each block of code in a language."""
    return [
        (page, code)
        for page in pages
        for code in re.findall(rf"```{language}\n(.*?)```", PAGES[page], re.DOTALL)
    ]


def commands():
    """Arguments of each `vibrissa` command, in the order of the pages."""
    lines = [line for _, code in blocks("console") for line in code.replace("\\\n", "").split("\n")]
    words = [shlex.split(line, comments=True) for line in lines]
    return [arguments for name, *arguments in filter(None, words) if name == "vibrissa"]

"""Write the pages that only the site has into docs/made: reference, notebooks, explorer."""

import re
import shutil
import subprocess
import sys
from enum import Enum
from importlib import import_module
from inspect import isclass, ismodule
from pathlib import Path
from typing import Any

from typer.main import get_command

from vibrissa.cli.app import COMMANDS, app, command_of
from vibrissa.explorer.page import page

DOCS = Path(__file__).parents[1]
ROOT = DOCS.parent
PUBLIC = ("vibrissa", "vibrissa.sensor", "vibrissa.design")
# A text in quotes, but not between two apostrophes; an option.
TYPED = re.compile(r"((?<!\w)'[^']+'(?!\w)|--[a-z][a-z0-9-]*)")


def escaped(text: str) -> str:
    """Convert a help text to Markdown: one line, with options and quoted text as code."""
    parts = TYPED.split(" ".join(text.split()))
    # The expression found every other part, from the second on.
    parts[::2] = [re.sub(r"([*|<\[])", r"\\\1", part) for part in parts[::2]]
    parts[1::2] = [f"`{part}`" for part in parts[1::2]]
    return "".join(parts)


def option_row(option: Any) -> str:
    """Write an option or an argument of a command as a row of a table."""
    names = ", ".join(f"`{name}`" for name in (*option.opts, *option.secondary_opts))
    kind = option.type_descriptor.annotation
    parts = [escaped(option.help)]
    if isinstance(kind, type) and issubclass(kind, Enum):
        parts.append("One of " + ", ".join(f"`{choice.value}`" for choice in kind) + ".")
    shown = option.default if option.show_default is True else option.show_default
    if shown not in (None, False, ()):
        parts.append(f"Default: `{shown.value if isinstance(shown, Enum) else shown}`.")
    return f"| {names} | {' '.join(parts)}{' **Required.**' * option.required} |"


def command_section(name: str, command: Any) -> list[str]:
    """Write the purpose, the example and the options of a command."""
    lines = [f"## `{name}`", ""]
    for paragraph in (command.help or "").split("\n\n"):
        lines += [" ".join(paragraph.split()), ""]
    if command.epilog:
        # As a block it can be copied.
        lines += ["```console", *re.findall("`([^`]+)`", command.epilog), "```", ""]
    rows = map(option_row, command.params)
    return [*lines, "| option | description |", "| --- | --- |", *rows, ""]


def commands() -> str:
    """Write the page of the command line."""
    lines = ["# Command line", "", "As `--help` prints it.", ""]
    lines += command_section("vibrissa", get_command(app))
    for name in COMMANDS:
        lines += command_section(f"vibrissa {name}", command_of(name))
    return "\n".join(lines)


def described(package: str, name: str) -> list[str]:
    """Write the Sphinx directive for a public name: a class, a function, a module or a value."""
    thing = getattr(import_module(package), name)
    if isclass(thing):
        return [f".. autoclass:: {name}", "   :members:", ""]
    if ismodule(thing):
        return [f".. automodule:: {package}.{name}", "   :members:", ""]
    if callable(thing):
        return [f".. autofunction:: {name}", ""]
    return [f".. autodata:: {name}", "   :no-value:", ""]


def public_names() -> str:
    """Write the page that lists the public names of each package."""
    lines = [
        "# Python names",
        "",
        "The public names. [Python](../python.md) has examples; everything else may change.",
    ]
    for package in PUBLIC:
        lines += ["", f"## `{package}`", "", "```{eval-rst}", f".. currentmodule:: {package}", ""]
        lines += [".. autosummary::", "   :nosignatures:", ""]
        lines += [f"   {name}" for name in import_module(package).__all__] + ["```"]
    return "\n".join([*lines, "", "```{toctree}", ":hidden:", "", *PUBLIC, "```", ""])


def package_page(package: str) -> str:
    """Write the page that describes the public names of a package."""
    lines = [f"# {package}", "", "```{eval-rst}", f".. currentmodule:: {package}", ""]
    for name in import_module(package).__all__:
        lines += described(package, name)
    return "\n".join([*lines, "```", ""])


def page_of_the_root(name: str) -> str:
    """Read a page of the root folder, and adapt its links to docs/made."""
    text = (ROOT / name).read_text(encoding="utf-8")
    text = re.sub(r"\]\(docs/", "](../", text)
    text = text.replace("](CONTRIBUTING.md", "](contributing.md")
    # A link to a file that is not a page becomes plain text.
    return re.sub(r"\[([^\]]+)\]\((?!\.\./|contributing|http|#)[^)]*\)", r"\1", text)


def gallery(folder: Path) -> None:
    """Run the lines of the gallery; each block saves its picture in the folder."""
    folder.mkdir(parents=True)
    text = (DOCS / "python.md").read_text(encoding="utf-8").partition("## Gallery")[2]
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    lines = "from vibrissa.figures import style\nimport matplotlib\nmatplotlib.use('Agg')\n"
    lines += "matplotlib.rcParams.update(style.SETTINGS)\n" + "\nplt.close()\n".join(blocks)
    subprocess.run([sys.executable, "-c", lines], cwd=folder, check=True)


def make(folder: Path) -> None:
    """Make the pages anew in a folder, which is emptied first."""
    shutil.rmtree(folder, ignore_errors=True)
    gallery(folder / "gallery")
    pages = {
        "commands.md": commands(),
        "python.md": public_names(),
        **{f"{package}.md": package_page(package) for package in PUBLIC},
        "contributing.md": page_of_the_root("CONTRIBUTING.md"),
        # Otherwise a search would find every word in it.
        "changelog.md": "---\nnosearch: true\n---\n" + page_of_the_root("CHANGELOG.md"),
        "explorer/play.html": page(home="index.html"),
    }
    for name, text in pages.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
    (folder / "notebooks").mkdir()
    for notebook in (ROOT / "examples").glob("*.ipynb"):
        shutil.copy(notebook, folder / "notebooks")

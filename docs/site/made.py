"""What is made for the site alone, into docs/made: reference, notebooks, pictures."""

import re
import shutil
import subprocess
import sys
from enum import Enum
from importlib import import_module
from inspect import getdoc
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

from packages import drawing
from typer.main import get_command

import vibrissa
from vibrissa.cli.app import COMMANDS, app, module_of
from vibrissa.explorer.page import page

DOCS = Path(__file__).parents[1]
EXAMPLES = DOCS.parent / "examples"
# Packages of which every module has a page, since the pages of the model name their functions;
# of the others only the public names are described.
WHOLE = ("mechanics", "sticking", "numerics", "sensor", "design", "proof", "study", "tables")
PUBLIC = ("vibrissa", "vibrissa.sensor", "vibrissa.design")
BESIDE = [
    module.name for module in iter_modules(vibrissa.__path__, "vibrissa.") if not module.ispkg
]
# A text in quotes, but not between two apostrophes; an option.
TYPED = re.compile(r"((?<!\w)'[^']+'(?!\w)|--[a-z][a-z0-9-]*)")


def escaped(text: str) -> str:
    """Put a help text into Markdown: in one line, what a user types as code."""
    parts = TYPED.split(" ".join(text.split()))
    # Every other part is what the expression found.
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
    """Write what a command does, its options and its example."""
    paragraphs = [" ".join(part.split()) for part in (command.help or "").split("\n\n")]
    lines = [f"## `{name}`", ""]
    for paragraph in paragraphs:
        lines += [paragraph, ""]
    if command.epilog:
        # As a block it can be copied.
        lines += ["```console", *re.findall("`([^`]+)`", command.epilog), "```", ""]
    return [
        *lines,
        "| option | what it is |",
        "| --- | --- |",
        *map(option_row, command.params),
        "",
    ]


def commands() -> str:
    """Write what every command says of itself."""
    lines = [
        "# Command line",
        "",
        "What `vibrissa` and each of its commands say with `--help`.",
        "",
    ]
    lines += command_section("vibrissa", get_command(app))
    for name in COMMANDS:
        lines += command_section(
            f"vibrissa {name}", get_command(import_module(module_of(name)).app)
        )
    return "\n".join(lines)


def modules(package: str) -> list[str]:
    """Names of a package's modules, with those of the packages within it."""
    found = []
    for module in iter_modules(import_module(package).__path__, f"{package}."):
        found += [module.name, *(modules(module.name) if module.ispkg else [])]
    return found


def summary(thing: object) -> str:
    """Give the first line of a docstring."""
    return (getdoc(thing) or "").partition("\n")[0]


def public_names() -> str:
    """Write the page of the names that a user imports."""
    lines = [
        "# Python",
        "",
        "What a user imports. Every function says its arguments, units and errors.",
    ]
    for package in PUBLIC:
        found = import_module(package)
        lines += ["", f"## `{package}`", "", "| name | what it is |", "| --- | --- |"]
        for name in found.__all__:
            thing = getattr(found, name)
            # A type or function is described where it is defined; a table of values is not.
            known = hasattr(thing, "__module__")
            link = f"[`{name}`](#{thing.__module__}.{name})" if known else f"`{name}`"
            lines.append(f"| {link} | {summary(thing) if known else 'values by name'} |")
    lines += ["", "## Modules", "", "| package | what it is for |", "| --- | --- |"]
    for name in WHOLE:
        about = summary(import_module(f"vibrissa.{name}"))
        lines.append(f"| [`vibrissa.{name}`](modules/{name}.md) | {about} |")
    lines += ["| [`vibrissa`](modules/vibrissa.md) | modules beside the packages |"]
    lines += ["", "```{toctree}", ":hidden:", ""]
    lines += [f"modules/{package}" for package in (*WHOLE, "vibrissa")]
    return "\n".join([*lines, "```", ""])


def module_page(package: str) -> str:
    """Write the page of all modules of a package, or of those beside the packages."""
    name = f"vibrissa.{package}" if package else "vibrissa"
    lines = [f"# {name}", "", "```{eval-rst}", f".. automodule:: {name}", "   :no-members:", "```"]
    for module in modules(name) if package else BESIDE:
        members = [] if hasattr(import_module(module), "__path__") else ["   :members:"]
        lines += ["", f"## `{module.removeprefix('vibrissa.')}`", "", "```{eval-rst}"]
        lines += [f".. automodule:: {module}", *members, "```"]
    return "\n".join([*lines, ""])


def gallery(folder: Path) -> None:
    """Run the lines of the gallery; each block saves its picture in the folder."""
    folder.mkdir(parents=True)
    page = (DOCS / "gallery.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    lines = "import matplotlib\nmatplotlib.use('Agg')\n" + "\nplt.close()\n".join(blocks)
    subprocess.run([sys.executable, "-c", lines], cwd=folder, check=True)


def make(folder: Path) -> None:
    """Make the pages anew.

    Parameters
    ----------
    folder : Path
        Is emptied first.
    """
    shutil.rmtree(folder, ignore_errors=True)
    pages = {
        "commands.md": commands(),
        "python.md": public_names(),
        "modules/vibrissa.md": module_page(""),
        **{f"modules/{package}.md": module_page(package) for package in WHOLE},
    }
    for name, text in pages.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    gallery(folder / "gallery")
    (folder / "packages.svg").write_text(drawing(), encoding="utf-8")
    (folder / "explorer").mkdir()
    (folder / "explorer/play.html").write_text(page(home="index.html"), encoding="utf-8")
    for notebook in EXAMPLES.glob("*.ipynb"):
        (folder / "notebooks").mkdir(exist_ok=True)
        shutil.copy(notebook, folder / "notebooks")

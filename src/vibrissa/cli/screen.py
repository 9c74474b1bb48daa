"""Text on the screen: wrapped at the width of a terminal, with the answer and doubts marked."""

import os
import re
import shutil
import sys
import textwrap

import typer

# The friction that a text begins with.
ANSWER = re.compile(r"mu0 = \S+( ± \S+)?(?=,)|mu0 = \S+ ± \S+ \(in doubt\)(?=,)")
# Beginnings of lines, with their colours.
COLORS = {
    re.compile(r"wrong:|do not rely on mu0"): typer.colors.RED,
    re.compile(r"doubtful:|warning:|\S+ periods? in doubt"): typer.colors.YELLOW,
}
# Blanks at which no line ends: after a sign or a number, and before a sign.
TOGETHER = re.compile(r" (?=[±=]( |$))|(?<=[±=]) |(?<=\d) (?=[a-zA-Z%°*]+\b)")
UNBROKEN, INDENT = "\N{NO-BREAK SPACE}", "  "


def wrapped(text: str, width: int) -> str:
    """Wrap lines longer than `width`; no line ends within a number or before its unit."""
    return "\n".join(part for line in text.split("\n") for part in _parts(line, width))


def _parts(line: str, width: int) -> list[str]:
    if len(line) <= width:
        return [line]
    margin = line[: len(line) - len(line.lstrip())]
    whole = TOGETHER.sub(UNBROKEN, line)
    parts = textwrap.wrap(
        whole,
        width,
        initial_indent="",
        subsequent_indent=margin + INDENT,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [part.replace(UNBROKEN, " ") for part in parts]


def emphasised(text: str) -> str:
    """Print the friction in bold, and the beginnings of doubts and warnings in colour."""
    return "\n".join(_emphasised(line) for line in text.split("\n"))


def _emphasised(line: str) -> str:
    if answer := ANSWER.match(line):
        return typer.style(answer[0], bold=True) + line[answer.end() :]
    for beginning, color in COLORS.items():
        if found := beginning.match(line):
            return typer.style(found[0], fg=color, bold=True) + line[found.end() :]
    return line


def say(text: str, err: bool = False) -> None:
    """Print a text; on a terminal, wrapped and with emphasis (without colours if NO_COLOR is set).

    Other programs read the lines as they are.
    """
    stream = sys.stderr if err else sys.stdout
    if stream.isatty():
        text = wrapped(text, shutil.get_terminal_size().columns)
        text = text if os.environ.get("NO_COLOR") else emphasised(text)
    typer.echo(text, err=err)

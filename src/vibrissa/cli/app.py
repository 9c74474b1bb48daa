"""The command line ``vibrissa``; each command is loaded when it is called."""

from difflib import get_close_matches
from importlib import import_module
from keyword import iskeyword
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from vibrissa.cli.screen import say
from vibrissa.errors import UndeterminedError, VibrissaError

HELP: dict[str, Any] = {"help_option_names": ["-h", "--help"]}
# Summary of each command, the same as in its own help: the list then need not load the commands.
COMMANDS = {
    "solve": "One rod on one surface: onset of slip, clamp reactions and largest strain.",
    "scan": "Move the clamp over a surface and write the signals, step by step.",
    "import": "Turn a laboratory's file into a recording for identify; report how it was read.",
    "identify": "Find the periods of sticking in a measured time series, and the friction of each.",
    "rod": "Fit taper and stiffness to a table of diameters and moduli of a real rod.",
    "design": "Find the rod that measures friction best, and the constraints that limit it.",
}


def command_of(name: str) -> Any:
    """Load a command from its module; if the name is a Python keyword, both end with ``_``."""
    own = name + "_" * iskeyword(name)
    return getattr(import_module(f"vibrissa.cli.{own}"), own)


class Commands(TyperGroup):
    """Group of the commands; an error of the user ends with a message and an exit code."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of the commands."""
        return list(COMMANDS)

    def get_command(self, ctx: Any, name: str) -> Any:
        """Return a command with its summary only, which is all that the list of commands needs."""
        return TyperCommand(name, help=COMMANDS[name]) if name in COMMANDS else None

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Load the called command, and the libraries that it imports; suggest a similar name."""
        near = get_close_matches(args[0], COMMANDS, n=1)
        if args[0] not in COMMANDS and near:
            ctx.fail(f"No such command '{args[0]}'. Did you mean '{near[0]}'?")
        name, _, rest = super().resolve_command(ctx, args)
        return name, command_of(str(name)), rest

    def invoke(self, ctx: Any) -> Any:
        """Run a command; after an error print its message and exit with code 1 or 2."""
        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            raise
        except VibrissaError as error:
            for line in str(error).splitlines():
                say(f"vibrissa: {line}", err=True)
            raise typer.Exit(1 if isinstance(error, UndeterminedError) else 2) from None
        except OSError as error:
            file = error.filename2 or error.filename
            place = "" if file is None else f"{file}: "
            typer.echo(f"vibrissa: {place}{error.strerror or error}", err=True)
            raise typer.Exit(2) from None


app = typer.Typer(
    name="vibrissa",
    cls=Commands,
    no_args_is_help=True,
    rich_markup_mode="markdown",
    context_settings=HELP,
    help="From a surface to the signals of a whisker-like sensor, and back to friction.\n\n"
    "Quantities have a unit, as in `--step '20 um'`, or are nondimensional without one: lengths "
    "in units of the rod's length L. Angles need a unit. With `--modulus`, `--diameter` and "
    "`--length` results are in SI units, otherwise nondimensional.",
)


def _print_version(wanted: bool) -> None:
    if wanted:
        from vibrissa import __version__
        from vibrissa.provenance import commit, why_unknown

        unknown = f" ({reason})" if (reason := why_unknown()) else ""
        typer.echo(f"vibrissa {__version__}, commit {commit()}{unknown}")
        raise typer.Exit


@app.callback()
def main(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print version and commit."
        ),
    ] = False,
) -> None:
    """Take the options that come before a command."""

"""The command line ``vibrissa``: puts the commands together, each loaded when it is called."""

from importlib import import_module
from keyword import iskeyword
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from vibrissa.cli import HELP
from vibrissa.errors import UndeterminedError, VibrissaError

# What the list of commands says of each. A command's own file, with NumPy, SciPy and the solvers,
# is imported only when that command is called.
COMMANDS = {
    "solve": "One rod on one surface: onset of slip, clamp reactions and largest strain.",
    "scan": "Move the clamp over a surface and write the signals, step by step.",
    "import": "Make a recording for identify from a laboratory's file, and report how it was read.",
    "identify": "Find the periods of sticking in a measured time series, and the friction of each.",
    "design": "Find the rod that measures friction best, and its active constraints.",
}


def module_of(name: str) -> str:
    """Name the module of a command; a keyword of Python gets an underscore."""
    return f"vibrissa.cli.{name}{'_' * iskeyword(name)}"


class Commands(TyperGroup):
    """Commands by name; ends with a line for each error that the user can correct."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        # As a short help a text is not shortened further.
        self.commands = {
            name: TyperCommand(name, short_help=text) for name, text in COMMANDS.items()
        }

    def resolve_command(self, ctx: Any, args: list[str]) -> tuple[str | None, Any, list[str]]:
        """Load the command of this call, and keep its arguments as typed."""
        name, command, rest = super().resolve_command(ctx, args)
        if name is not None and command is not None:
            command = typer.main.get_command(import_module(module_of(name)).app)
        return name, command, rest

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            raise
        except VibrissaError as error:
            for line in str(error).splitlines():
                typer.echo(f"vibrissa: {line}", err=True)
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
        from vibrissa.provenance import commit

        typer.echo(f"vibrissa {__version__}, commit {commit()}")
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

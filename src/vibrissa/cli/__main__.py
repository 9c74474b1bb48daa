"""The command `vibrissa` as a module: ``python -m vibrissa.cli``."""

from vibrissa.cli.app import app

app(prog_name="vibrissa")

"""Proved numbers: equilibria of the rod, enclosed with all rounding and truncation errors."""

from vibrissa.errors import VibrissaError


class NotProvedError(VibrissaError):
    """No proof of a statement was found; the message names the step that failed."""

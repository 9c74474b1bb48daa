"""Proved numbers: equilibria of the rod, enclosed with every error of rounding and truncation."""

from vibrissa.errors import VibrissaError


class NotProvedError(VibrissaError):
    """A statement for which no proof was found; the message says at which step."""

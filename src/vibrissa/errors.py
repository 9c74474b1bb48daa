"""Exceptions: one base class and its kinds; any other exception is a fault of the program."""

from pathlib import Path


class VibrissaError(Exception):
    """Invalid input or environment; the message gives a remedy."""


class MissingExtraError(VibrissaError, ImportError):
    """A library is not installed; the message has the command that installs it."""


class ArgumentError(VibrissaError, ValueError):
    """An argument is invalid; the message has its name, its value and the allowed values."""


class UnknownNameError(ArgumentError):
    """An unknown name; the message lists the known ones."""


class StudyError(VibrissaError):
    """An invalid study file; the message is its first mistake.

    Attributes
    ----------
    mistakes : tuple of str
        Each with the key, the value and what is allowed.
    """

    def __init__(self, first: str, *others: str) -> None:
        super().__init__(first)
        self.mistakes = (first, *others)


class TableError(VibrissaError):
    """A table that cannot be read, has other columns or is of another study."""


class DamagedTableError(TableError):
    """A table whose file must be deleted, so that the next run makes it again."""

    REMEDY = "delete it and run again: it is made again"

    def __init__(self, path: str | Path, reason: str, remedy: str = REMEDY) -> None:
        super().__init__(f"{path} {reason}; {remedy}")
        self.path = Path(path)


class ComparisonError(VibrissaError):
    """Tables that cannot be compared with their references."""


class RecordingError(VibrissaError, ValueError):
    """A measured table that cannot be read or used; the message names the line."""


class OtherTableError(RecordingError):
    """A table without the required columns, or no CSV; perhaps another program's."""


class UndeterminedError(RecordingError):
    """A recording that does not determine the quantity to be estimated."""


class WrongRodError(RecordingError):
    """A recording that does not fit the given rod."""


class MixedColumnsError(RecordingError):
    """A recording whose columns are mixed up: axes, signs or units."""


class NoResponseError(ArgumentError):
    """A rod whose response, or its retraction, was not found."""

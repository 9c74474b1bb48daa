"""Exceptions for invalid input or an unsuitable environment; any other exception is a bug."""

from pathlib import Path
from typing import Any


class VibrissaError(Exception):
    """Invalid input or environment; the message gives a remedy."""


class MissingExtraError(VibrissaError, ImportError):
    """An optional library is not installed; the message gives the command that installs it."""


class ArgumentError(VibrissaError, ValueError):
    """An argument is invalid; the message gives its name, its value and the allowed values."""


class EndedScanError(ArgumentError):
    """A scan that cannot go on, as the tip leaves its surface; `scan` has the steps up to there."""

    def __init__(self, message: str, scan: Any) -> None:
        super().__init__(message)
        self.scan = scan


class UnknownNameError(ArgumentError):
    """An unknown name; the message lists the known ones."""


class StudyError(VibrissaError):
    """An invalid study file; each line of the message is a mistake, with what is allowed."""


class TableError(VibrissaError):
    """A table that cannot be read, has wrong columns or belongs to another study."""


class DamagedTableError(TableError):
    """A damaged table; delete its file, and the next run writes it again."""

    REMEDY = "delete this table and run again: it is made again"

    def __init__(self, path: str | Path, reason: str, remedy: str = REMEDY) -> None:
        super().__init__(f"{path} {reason}; {remedy}")
        self.path = Path(path)
        self.reason = reason


class ComparisonError(VibrissaError):
    """Tables that cannot be compared with their references."""


class RecordingError(VibrissaError, ValueError):
    """A recording (a table of measurements) that cannot be read or used."""


class OtherTableError(RecordingError):
    """A file that lacks required columns or is no CSV file, such as one of another program."""


class UndeterminedError(RecordingError):
    """A recording that does not determine the quantity to be estimated."""


class WrongRodError(RecordingError):
    """A recording that does not fit the given rod."""


class MixedColumnsError(RecordingError):
    """A recording whose columns are mixed up: axes, signs or units."""


class NoResponseError(ArgumentError):
    """A rod whose clamp signals could not be computed at a distance that its stage reaches."""

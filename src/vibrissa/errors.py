"""What can go wrong, as types: one base class and its kinds.

A person reads the message. Code that handles an error acts on its type and its attributes, never on
its words. What is none of these is a mistake in the program and is shown as one.
"""

from pathlib import Path


class VibrissaError(Exception):
    """Something outside the program is not as it should be; the message says what to do."""


class MissingExtraError(VibrissaError, ImportError):
    """A library that is not installed; the message says how to install it."""


class ArgumentError(VibrissaError, ValueError):
    """An argument that is out of range; the message names it, its value and what is allowed."""


class UnknownNameError(ArgumentError):
    """A name that is none of those that there are; the message spells them as they stand there."""


class StudyError(VibrissaError):
    """A study file that cannot be run; the message is that of its first mistake.

    Attributes
    ----------
    mistakes : tuple of str
        A line for each mistake: the key, the value and what is allowed.
    """

    def __init__(self, first: str, *others: str) -> None:
        super().__init__(first)
        self.mistakes = (first, *others)


class TableError(VibrissaError):
    """A table that cannot be read or is not what it should be."""


class DamagedTableError(TableError):
    """A table whose file must be deleted, so that it is made anew.

    Attributes
    ----------
    path : Path
        The file.
    """

    def __init__(
        self,
        path: str | Path,
        reason: str,
        remedy: str = "delete it and run again, it is made anew",
    ) -> None:
        super().__init__(f"{path} {reason}; {remedy}")
        self.path = Path(path)


class ClusterError(VibrissaError):
    """A cluster that does not answer or does not take the jobs; the message has its words."""


class ComparisonError(VibrissaError):
    """Tables that cannot be compared with their references."""


class RecordingError(VibrissaError, ValueError):
    """A measured table that cannot be read or used; the message names the line."""


class OtherTableError(RecordingError):
    """A table that has not the columns that are needed, or is no CSV: of another program, maybe."""


class UndeterminedError(RecordingError):
    """A recording that does not determine what is to be estimated from it."""


class WrongRodError(RecordingError):
    """A recording whose readings are not those of the rod that was given."""


class MixedColumnsError(RecordingError):
    """A recording whose columns are mixed up: axes, signs or units."""


class NoResponseError(ArgumentError):
    """A rod whose response was not found, or not found where the clamp pulls."""

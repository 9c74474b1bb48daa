"""Optional libraries, which `pip install vibrissa` leaves out."""

import sys
from importlib.util import find_spec

from vibrissa.errors import MissingExtraError


def require(extra: str, *libraries: str) -> None:
    """Raise an error with the command to install, if one of these libraries is missing.

    Raises
    ------
    MissingExtraError
        If one of them is not installed.
    SystemExit
        Instead, while Python looks for the program that ``python -m`` names.
    """
    missing = [library for library in libraries if find_spec(library) is None]
    if missing:
        line = f"this needs {', '.join(missing)}: pip install 'vibrissa[{extra}]'"
        if sys.argv[0] == "-m":
            sys.exit(line)
        raise MissingExtraError(line)

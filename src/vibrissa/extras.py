"""Check for optional libraries, which `pip install vibrissa` does not install."""

import sys
from importlib.util import find_spec

from vibrissa.errors import MissingExtraError


def require(extra: str, *libraries: str) -> None:
    """Raise an error with the install command if one of the libraries is missing.

    Raises
    ------
    MissingExtraError
        If a library is not installed.
    SystemExit
        Raised instead while ``python -m`` imports the package, so that no traceback is printed.
    """
    missing = [library for library in libraries if find_spec(library) is None]
    if missing:
        line = f"this needs {', '.join(missing)}: pip install 'vibrissa[{extra}]'"
        if sys.argv[0] == "-m":
            sys.exit(line)
        raise MissingExtraError(line)

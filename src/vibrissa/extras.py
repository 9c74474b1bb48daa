"""What `pip install vibrissa` leaves out: libraries that only some parts of the program need."""

import sys
from importlib.util import find_spec

from vibrissa.errors import MissingExtraError


def require(extra: str, *libraries: str) -> None:
    """Say what to install where libraries are missing.

    Parameters
    ----------
    extra : str
        Extra of pyproject.toml that has them.
    *libraries : str
        Names as they are imported.

    Raises
    ------
    MissingExtraError
        If one of them is not installed.
    SystemExit
        If that is found while Python looks for the program that ``python -m`` names: nobody could
        catch the error there.
    """
    missing = [library for library in libraries if find_spec(library) is None]
    if missing:
        line = f"this needs {', '.join(missing)}: pip install 'vibrissa[{extra}]'"
        if sys.argv[0] == "-m":
            sys.exit(line)
        raise MissingExtraError(line)

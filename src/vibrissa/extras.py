"""What `pip install vibrissa` leaves out: libraries that only some parts of the program need."""

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
    """
    missing = [library for library in libraries if find_spec(library) is None]
    if missing:
        names = ", ".join(missing)
        raise MissingExtraError(f"this needs {names}: pip install 'vibrissa[{extra}]'")

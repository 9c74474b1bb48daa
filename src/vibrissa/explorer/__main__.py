"""Write the explorer into a file: ``python -m vibrissa.explorer explorer.html``."""

import sys
from pathlib import Path

from vibrissa.extras import require
from vibrissa.files import write_atomically


def main(arguments: list[str]) -> str:
    """Write the explorer to the file in `arguments`; return an error message, or an empty text."""
    if len(arguments) != 1:
        return "give a file to write: python -m vibrissa.explorer explorer.html"
    require("workflow", "jinja2")
    from vibrissa.explorer.page import page

    path = Path(arguments[0])
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with write_atomically(path) as temporary:
            temporary.write_text(page(), encoding="utf-8")
    except OSError as error:
        return f"the explorer cannot be written: {error}"
    print(f"open {path.resolve().as_uri()} in a browser")
    return ""


if __name__ == "__main__":
    # An empty text would count as a failure, too.
    sys.exit(main(sys.argv[1:]) or 0)

"""Write the explorer into a file: ``python -m vibrissa.explorer explorer.html``."""

import sys
from argparse import ArgumentParser
from pathlib import Path

from vibrissa.errors import MissingExtraError
from vibrissa.extras import require
from vibrissa.files import write_atomically


def main(arguments: list[str]) -> None:
    """Write the explorer to the file in `arguments`; exit with a message if this fails."""
    parser = ArgumentParser("python -m vibrissa.explorer", description="Write the explorer.")
    parser.add_argument("file", type=Path, help="file to write, such as explorer.html")
    path = parser.parse_args(arguments).file
    try:
        require("workflow", "jinja2", "yaml")
        from vibrissa.explorer.page import page

        path.parent.mkdir(parents=True, exist_ok=True)
        with write_atomically(path) as temporary:
            temporary.write_text(page(), encoding="utf-8")
    except (MissingExtraError, OSError) as error:
        sys.exit(f"the explorer cannot be written: {error}")
    print(f"open {path.resolve().as_uri()} in a browser")


if __name__ == "__main__":
    main(sys.argv[1:])

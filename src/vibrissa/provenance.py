"""Which code is running: the commit that it is from."""

import subprocess
from pathlib import Path

_PACKAGE = Path(__file__).parent
# Beside the package where it was installed from a wheel; written by hatch_build.py.
COMMIT_FILE = "commit.txt"


def commit() -> str:
    """Commit of the code that is running, with ``-dirty`` if it was edited; or ``unknown``."""

    def git(*arguments: str) -> str:
        command = ["git", "-C", str(_PACKAGE), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    recorded = _PACKAGE / COMMIT_FILE
    if recorded.is_file():
        return recorded.read_text(encoding="utf-8").strip()
    try:
        # Inside somebody else's repository, that repository's commit says nothing.
        git("ls-files", "--error-unmatch", __file__)
        return git("describe", "--always", "--dirty", "--abbrev=40", "--exclude=*")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"

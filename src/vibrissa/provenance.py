"""Which code is running: the commit that it is from."""

import subprocess
from pathlib import Path

_PACKAGE = Path(__file__).parent
# Beside the package where it was installed from a wheel; written by hatch_build.py.
COMMIT_FILE = "commit.txt"
# What a number may depend on, relative to the clone. A study file does not belong to it: a table
# holds its text.
CODE = (
    *("Snakefile", "Makefile", "pyproject.toml", "hatch_build.py"),
    *("requirements.lock", "environment.yml", "src", "workflow"),
)
# Of that, what says only where jobs run: an account of a cluster changes no number.
PROFILES = "workflow/profiles"


def commit() -> str:
    """Commit of the code that is running, with ``-dirty`` if it was edited; or ``unknown``."""

    def git(*arguments: str) -> str:
        command = ["git", "-C", str(_PACKAGE.parents[1]), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    recorded = _PACKAGE / COMMIT_FILE
    if recorded.is_file():
        return recorded.read_text(encoding="utf-8").strip()
    try:
        # Inside somebody else's repository, that repository's commit says nothing.
        git("ls-files", "--error-unmatch", str(_PACKAGE / "provenance.py"))
        edited = git("diff", "--name-only", "HEAD", "--", *CODE, f":(exclude){PROFILES}")
        return git("rev-parse", "HEAD") + ("-dirty" if edited else "")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"

"""Version of the running code: its commit, and a digest of its sources."""

import hashlib
import subprocess
from pathlib import Path

_PACKAGE = Path(__file__).parent
# Beside the package where it was installed from a wheel; written by hatch_build.py.
COMMIT_FILE = "commit.txt"
# Sources of the package, also those of web pages.
SOURCES = (".py", ".html", ".css", ".js")
# What a number may depend on, relative to the clone. A study file does not belong to it: a table
# holds its text.
CODE = (
    *("Snakefile", "Makefile", "pyproject.toml", "hatch_build.py"),
    *("locks", "environment.yml", "src", "workflow"),
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


def digest(*parts: str) -> str:
    """Digest of sources, on which a job can depend.

    Of `parts`, subpackages or modules such as ``study/axes.py``, and of the modules beside the
    packages; without parts, of the whole package.
    """
    wanted = {_PACKAGE / part for part in parts} or {_PACKAGE}
    total = hashlib.sha256()
    for path in sorted(_PACKAGE.rglob("*")):
        is_wanted = path.parent == _PACKAGE or wanted & {path, *path.parents}
        if is_wanted and path.suffix in SOURCES:
            total.update(f"{path.relative_to(_PACKAGE)}\n".encode() + path.read_bytes())
    return total.hexdigest()[:16]

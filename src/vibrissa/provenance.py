"""Version of the running code: its commit, and a digest of its sources."""

import hashlib
import subprocess
from pathlib import Path

_PACKAGE = Path(__file__).parent
# File in the package that records the commit; hatch_build.py writes it into a wheel.
COMMIT_FILE = "commit.txt"
# Suffixes of the package's sources, including web pages and tables of data.
SOURCES = (".py", ".toml", ".yaml", ".html", ".css", ".js")
# Paths in the clone on which results may depend. Study files are left out: each table stores the
# text of its own.
CODE = (
    *("Snakefile", "Makefile", "pyproject.toml", "hatch_build.py"),
    *("locks", "environment.yml", "src", "workflow"),
)
# Profiles only select where jobs run, so that editing them does not mark the code as edited.
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
        # This fails if the package lies in a repository of another project.
        git("ls-files", "--error-unmatch", str(_PACKAGE / "provenance.py"))
        edited = git("diff", "--name-only", "HEAD", "--", *CODE, f":(exclude){PROFILES}")
        return git("rev-parse", "HEAD") + ("-dirty" if edited else "")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def digest(*parts: str) -> str:
    """Compute a digest of source files, so that a job can depend on them.

    It covers the modules directly in the package, and the subpackages or modules named by `parts`,
    such as ``study`` or ``study/axes.py``.
    """
    wanted = {_PACKAGE / part for part in parts}
    total = hashlib.sha256()
    for path in sorted(_PACKAGE.rglob("*")):
        is_wanted = path.parent == _PACKAGE or wanted & {path, *path.parents}
        # An editor may make a link to nowhere that is named like a source file.
        if is_wanted and path.suffix in SOURCES and path.is_file():
            total.update(f"{path.relative_to(_PACKAGE)}\n".encode() + path.read_bytes())
    return total.hexdigest()[:16]

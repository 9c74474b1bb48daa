"""Version of the running code: its commit, a digest of its sources, versions of libraries."""

import hashlib
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

_PACKAGE = Path(__file__).resolve().parent
# File in the package that records the commit; hatch_build.py writes it into a wheel.
COMMIT_FILE = "commit.txt"
# Suffixes of the package's sources, including lists of public names, web pages and tables of data.
SOURCES = (".py", ".pyi", ".toml", ".yaml", ".html", ".css", ".js")
# Paths in the clone on which results may depend. Study files are left out: each table stores the
# text of its own.
CODE = (
    "Snakefile",
    "Makefile",
    "pyproject.toml",
    "hatch_build.py",
    "locks",
    "environment.yml",
    "src",
    "workflow",
)
# Profiles only select where jobs run, so that editing them does not mark the code as edited.
PROFILES = "workflow/profiles"

UNKNOWN = "unknown"
# The code that computes the tables, and the libraries that decide their numbers.
_SOLVER = (
    "numerics",
    "mechanics",
    "sticking",
    "computing",
    "study/axes.py",
    "study/chunks.py",
    "tables",
)
_SOLVER_LIBRARIES = ("numpy", "scipy")
# What also determines the tables of scans.
_SCANNING = ("scanning", "study/data_files.py", "study/surfaces.py")
SCANNED = frozenset(("scans", "periods"))
# What also determines the table of friction, and the libraries that decide its numbers.
_READING = ("readings", "sensor", "design", "quantities", "study/readings.py")
_READING_LIBRARIES = ("pandas", "pint")
# What also determines figures, verdicts, summary and report.
_DISPLAY = ("study", "figures", "paper", "report", "explorer")
_DISPLAY_LIBRARIES = ("pandas", "pyarrow", "matplotlib")


def commit() -> str:
    """Commit of the code that is running, with ``-dirty`` if it was edited; or ``unknown``."""
    return _asked().name


def why_unknown() -> str:
    """Return why the commit is unknown, and what to type; empty if it is known."""
    return _asked().reason


class _Commit(NamedTuple):
    name: str
    reason: str = ""


def _asked() -> _Commit:
    """Ask the file that a build wrote, or git."""
    root = _PACKAGE.parents[1]

    def git(*arguments: str) -> str:
        # git refuses the clone of another user, as its settings may name programs to run. The code
        # that runs here is from this clone already, so that its settings may be trusted, too.
        command = ["git", "-c", f"safe.directory={root}", "-C", str(root), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    recorded = _PACKAGE / COMMIT_FILE
    if recorded.is_file():
        name = recorded.read_text(encoding="utf-8").strip()
        reason = "it was unknown when this package was built: install git, and build it in a clone"
        return _Commit(name, reason if name == UNKNOWN else "")
    try:
        # This fails if the package lies in a repository of another project.
        git("ls-files", "--error-unmatch", str(_PACKAGE / "provenance.py"))
        edited = git("diff", "--name-only", "HEAD", "--", *CODE, f":(exclude){PROFILES}")
        return _Commit(git("rev-parse", "HEAD") + ("-dirty" if edited else ""))
    except OSError as error:
        return _Commit(UNKNOWN, f"git cannot be run ({error.strerror}): install git")
    except subprocess.CalledProcessError as error:
        told = (error.stderr or "").strip().splitlines() or ["git failed"]
        return _Commit(UNKNOWN, f"{told[0]}; clone the project with git")


def code_of(table: str) -> str:
    """Describe the code that makes a table: a digest of its sources, and versions of libraries.

    Every table carries this text; see `vibrissa.tables.store`.

    Parameters
    ----------
    table : str
        Name of the table, such as ``stiction``.
    """
    if table == "claims":
        return ", ".join(display_code())
    if table == "friction":
        return ", ".join(reading_code())
    return ", ".join(scanning_code() if table in SCANNED else solver_code())


def solver_code() -> list[str]:
    """Describe the code that computes the tables; equal lists give equal tables."""
    return [
        f"code {digest(*_SOLVER)}",
        "Python {}.{}".format(*sys.version_info),
        *(f"{library} {version(library)}" for library in _SOLVER_LIBRARIES),
    ]


def scanning_code() -> list[str]:
    """Describe the code that computes the tables of scans."""
    return [f"scans {digest(*_SCANNING)}", *solver_code()]


def reading_code() -> list[str]:
    """Describe the code that simulates recordings and reads friction from them."""
    return [
        f"readings {digest(*_READING)}",
        *scanning_code(),
        *(f"{library} {version(library)}" for library in _READING_LIBRARIES),
    ]


def display_code() -> list[str]:
    """Describe the code that makes figures, verdicts, summary and report from tables."""
    return [
        f"display {digest(*_DISPLAY)}",
        *solver_code(),
        *(f"{library} {version(library)}" for library in _DISPLAY_LIBRARIES),
    ]


def digest(*parts: str) -> str:
    """Compute a digest of the contents of source files.

    It covers the modules directly in the package, the subpackages or modules named by `parts`, such
    as ``study`` or ``study/axes.py``, and the scripts of the workflow.
    """
    scripts = _home() / "workflow/scripts"
    sources = list(_PACKAGE.glob("*.py"))
    for part in parts:
        path = _PACKAGE / part
        sources += [path] if path.is_file() else path.rglob("*")
    # Named alike in a clone and in a wheel, which has the workflow in the package.
    named = {path.relative_to(_PACKAGE).as_posix(): path for path in sources}
    named |= {f"workflow/scripts/{path.name}": path for path in scripts.glob("*.py")}
    total = hashlib.sha256()
    for name, path in sorted(named.items()):
        # An editor may make a link to nowhere that is named like a source file.
        if path.suffix in SOURCES and path.is_file():
            total.update(f"{name}\n".encode() + path.read_bytes())
    return total.hexdigest()[:16]


def _home() -> Path:
    """Folder of the workflow: the clone, or the package in a wheel."""
    return _PACKAGE if (_PACKAGE / "Snakefile").is_file() else _PACKAGE.parents[1]

"""Where the workflow is: in the clone that this package belongs to, or in an installed wheel."""

from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
# A wheel has below the package what a clone has in its root; hatch_build.py puts it there.
HOME = PACKAGE if (PACKAGE / "Snakefile").is_file() else PACKAGE.parents[1]
SNAKEFILE = HOME / "Snakefile"
PAPER = HOME / "config.yaml"


def near(path: Path) -> Path:
    """Shorten a path below the working directory."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path

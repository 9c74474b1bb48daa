"""Location of the workflow: in a clone of the project, or in an installed wheel."""

from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
# A clone has the workflow in its root, a wheel has it in the package (hatch_build.py).
HOME = PACKAGE if (PACKAGE / "Snakefile").is_file() else PACKAGE.parents[1]
SNAKEFILE = HOME / "Snakefile"
PAPER = HOME / "config.yaml"


def near(path: Path) -> Path:
    """Return a path inside the working directory relative to it, and any other path unchanged."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path

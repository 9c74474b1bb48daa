"""Where the workflow is: in the clone that this package belongs to, or in an installed wheel."""

from pathlib import Path

from vibrissa.tables.proofs import FILE

PACKAGE = Path(__file__).resolve().parents[1]
# A wheel has below the package what a clone has in its root; hatch_build.py puts it there.
HOME = PACKAGE if (PACKAGE / "Snakefile").is_file() else PACKAGE.parents[1]
SNAKEFILE = HOME / "Snakefile"
PAPER = HOME / "config.yaml"
PROFILES = HOME / "workflow/profiles"
CHECK = HOME / "workflow/check.py"


def near(path: Path) -> Path:
    """Shorten a path below the working directory."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path


def reference_tables(study: str) -> Path:
    """Folder of a study's reference tables: here, or else those of the workflow."""
    here = Path("tests/regression", study)
    own = HOME / here
    return here if here.is_dir() or not own.is_dir() else near(own)


def proofs(study: str) -> list[str]:
    """Files of what is proved of a study: that beside its reference tables, if there is one."""
    path = reference_tables(study) / FILE
    return [path.as_posix()] if path.is_file() else []

"""Make the results of an unpacked archive again and compare them; used by `make verify` there.

Usage: python workflow/verify.py [FOLDER]

Exit status 1 if a table moved, 2 if that cannot be found out.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from check import layouts_of

from vibrissa.archive.crate import ArchiveError, checked_files, study_file_of
from vibrissa.checking.reference import Comparison, compare_folders
from vibrissa.errors import VibrissaError
from vibrissa.study.reading import read_study


def verify(folder: Path, scratch: Path) -> Comparison:
    """Copy an unpacked archive without its results, run its study there, and compare."""
    for name in checked_files(folder):
        if not name.startswith("results/"):
            (scratch / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(folder / name, scratch / name)
    study_file = study_file_of(folder)
    command = [sys.executable, "-m", "vibrissa.pipeline", "--configfile", study_file]
    if subprocess.run(command, cwd=scratch, check=False).returncode:
        raise ArchiveError("the study did not run to its end; see above")
    results = Path("results", read_study(folder / study_file).name)
    return compare_folders(scratch / results, folder / results, layouts_of(folder))


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Make archived results again and compare them.")
    parser.add_argument("folder", type=Path, nargs="?", default=Path())
    try:
        with TemporaryDirectory(prefix="vibrissa-") as scratch:
            found = verify(parser.parse_args(argv).folder, Path(scratch))
    except (VibrissaError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    for difference in found.differences:
        print(difference.text)
    print(found.verdict)
    return 1 if found.differences else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

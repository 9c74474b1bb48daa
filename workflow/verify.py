"""Reproduce the results of an unpacked archive and compare them; used by its `make verify`.

Usage: python workflow/verify.py [FOLDER]

Exit status 1 if a table differs, 2 if the tables cannot be compared.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from check import layouts_of

from vibrissa.archive.crate import ArchiveError
from vibrissa.checking.reference import Comparison, compare_folders
from vibrissa.errors import VibrissaError
from vibrissa.study.reading import read_study


def verify(folder: Path, scratch: str) -> Comparison:
    """Run the study of an unpacked archive in a scratch folder, and compare the results."""
    study_file = folder / "config.yaml"
    study = read_study(study_file)
    results = Path("results", study.name)
    for name in (f"tables/{table}.parquet" for table in study.tables):
        if not (folder / results / name).is_file():
            raise ArchiveError(f"{results} has no file {name}; unpack the archive again")
    command = [sys.executable, "-m", "vibrissa.pipeline", "--snakefile", str(folder / "Snakefile")]
    command += ["--configfile", str(study_file), "--directory", scratch]
    if subprocess.run(command, check=False).returncode:
        raise ArchiveError("the study did not run to its end; see above")
    return compare_folders(scratch / results, folder / results, layouts_of(folder))


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Reproduce archived results and compare them.")
    parser.add_argument("folder", type=Path, nargs="?", default=Path())
    try:
        with TemporaryDirectory(prefix="vibrissa-") as scratch:
            found = verify(parser.parse_args(argv).folder.absolute(), scratch)
    except (VibrissaError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    for difference in found.differences:
        print(difference.text)
    print(found.verdict)
    return 1 if found.differences else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""Archive a study, its results and its code as one file, an RO-Crate; used by `make archive`.

Usage: python workflow/archive.py [--configfile FILE] [--output FILE]

By default, archive config.yaml to results/<study>.crate.zip. The results must be current.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from vibrissa.archive.crate import need_committed, write_archive
from vibrissa.errors import VibrissaError
from vibrissa.pipeline import outdated, places
from vibrissa.provenance import commit
from vibrissa.study.reading import read_study


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Archive a study as one file, an RO-Crate.")
    parser.add_argument("--configfile", type=Path, default=places.PAPER, help="study file")
    parser.add_argument("--output", type=Path, help="default: results/<study>.crate.zip")
    options = parser.parse_args(argv)
    try:
        study = read_study(options.configfile)
        results = Path("results", study.name)
        output = options.output or results.with_name(f"{study.name}.crate.zip")
        outdated.need_current(study, options.configfile, study.results)
        version = commit()
        need_committed(version, (results / f"tables/{name}.parquet" for name in study.tables))
        number = write_archive(
            places.HOME,
            results,
            study.results,
            options.configfile,
            version,
            output,
            study.data_files,
        )
    except (VibrissaError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(f"{output} holds {number} files; to check its results, unpack it and run make verify")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

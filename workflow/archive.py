"""Put a study with all that made it into one file, an RO-Crate; used by `make archive`.

Usage: python workflow/archive.py [--configfile FILE] [--output FILE]

Without options: config.yaml, into results/<study>.crate.zip. The results must be current.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from vibrissa.archive.crate import write_archive
from vibrissa.errors import VibrissaError
from vibrissa.pipeline import outdated, places
from vibrissa.provenance import commit
from vibrissa.study.reading import read_study


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Put a study into one file, an RO-Crate.")
    parser.add_argument("--configfile", type=Path, default=places.PAPER, help="study file")
    parser.add_argument("--output", type=Path, help="instead of results/<study>.crate.zip")
    options = parser.parse_args(argv)
    try:
        study = read_study(options.configfile)
        results = Path("results", study.name)
        output = options.output or results.with_name(f"{study.name}.crate.zip")
        outdated.need_current(study, options.configfile)
        number = write_archive(
            places.HOME,
            results,
            study.results,
            options.configfile,
            commit(),
            output,
            [figure.script for figure in study.figures.values() if figure.script],
        )
    except (VibrissaError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(f"{output} holds {number} files; unpacked, make verify makes its results again")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

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
from vibrissa.pipeline import repair, staleness
from vibrissa.pipeline.places import HOME, PAPER
from vibrissa.pipeline.run import study_of
from vibrissa.provenance import commit


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Put a study into one file, an RO-Crate.")
    parser.add_argument("--configfile", help="study file, instead of config.yaml")
    parser.add_argument("--output", type=Path, help="instead of results/<study>.crate.zip")
    options = parser.parse_args(argv)
    study, made = study_of([options.configfile] if options.configfile else [])
    results = Path("results", study)
    output = options.output or results.with_name(f"{study}.crate.zip")
    study_file = Path(options.configfile or PAPER)
    try:
        staleness.need_current(results, options.configfile, everything=True)
        files = write_archive(HOME, results, made, study_file, commit(), output)
    except (VibrissaError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if others := repair.others(results, made):
        print(others)
    print(f"{output} holds {len(files)} files; unpacked, make verify makes its results again")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

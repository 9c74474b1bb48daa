"""Make the results of an unpacked archive again and compare them; used by `make verify` there.

Usage: python workflow/verify.py [FOLDER]

Exit status 1 if a file is not the same, bit for bit, 2 if that cannot be found out.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from vibrissa.archive import reproduction
from vibrissa.archive.crate import ArchiveError
from vibrissa.errors import VibrissaError


def verify(folder: Path) -> list[str]:
    recorded = reproduction.checksums(folder)
    if damaged := list(reproduction.damaged(folder, recorded)):
        raise ArchiveError(f"the archive is damaged: {'; '.join(damaged)}; unpack it again")
    with TemporaryDirectory(prefix="vibrissa-") as name:
        scratch = Path(name)
        if reproduction.run_again(folder, recorded, scratch):
            raise ArchiveError("the study did not run to its end; see above")
        lines = list(reproduction.differences(folder, scratch, recorded))
    made = [name for name in recorded if name.startswith("results/")]
    same = len(made) - len(lines) - sum(Path(name).name == reproduction.TIMED for name in made)
    print(f"{same} of {same + len(lines)} results are the same, bit for bit.")
    return lines


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Make archived results again and compare them.")
    parser.add_argument("folder", type=Path, nargs="?", default=Path())
    try:
        lines = verify(parser.parse_args(argv).folder)
    except (VibrissaError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    for line in lines:
        print(line)
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

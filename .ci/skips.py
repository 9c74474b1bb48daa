"""Say which tests were skipped and why, from the reports that pytest writes (JUnit's XML).

Usage: python .ci/skips.py REPORT            print the reasons, each with how many tests it skipped
       python .ci/skips.py --files REPORT    print the files with a skipped test
       python .ci/skips.py REPORT SECOND     fail if a test is skipped in both reports
"""

import sys
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree


def skipped(report):
    """Reasons of the skipped tests, by file and name; nothing where there is no report."""
    if not Path(report).is_file():
        return {}
    found = {}
    for case in ElementTree.parse(report).iter("testcase"):
        reason = case.find("skipped")
        if reason is not None:
            # pytest names the module, and where all of it is skipped, nothing else.
            module = case.get("classname") or case.get("name")
            found[module, case.get("name")] = reason.get("message")
    return found


def file_of(module):
    """Path of a test module, whose name may be followed by that of a class."""
    parts = module.split(".")
    paths = (Path(*parts[:n]).with_suffix(".py") for n in range(len(parts), 0, -1))
    return next(path for path in paths if path.is_file())


def main(arguments):
    """Do what the arguments say; return the exit status."""
    if arguments[0] == "--files":
        print(*sorted({str(file_of(module)) for module, _ in skipped(arguments[1])}), sep="\n")
        return 0
    first, *second = map(skipped, arguments)
    if not second:
        print(f"{len(first)} tests were skipped:")
        for reason, count in Counter(first.values()).most_common():
            print(f"  {count}: {reason}")
        return 0
    never = [
        f"{file_of(module)}::{name}: {second[0][module, name]}"
        for module, name in first.keys() & second[0]
    ]
    for line in sorted(never):
        print(f"never run: {line}")
    print(f"{len(never)} tests were run nowhere")
    return 1 if never else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

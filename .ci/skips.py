"""Say which tests were skipped and why, from the reports that pytest writes (JUnit's XML).

Usage: python .ci/skips.py REPORT            print the reasons, each with how many tests it skipped
       python .ci/skips.py --tests REPORT    print the skipped tests, as pytest takes them
       python .ci/skips.py --none REPORT     fail if there is one, and name it
"""

import sys
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree


def skipped(report):
    """Reasons of the skipped tests, by file and name."""
    if not Path(report).is_file():
        sys.exit(f"there is no report {report}: run the tests first")
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


def node(module, name):
    """Return what pytest calls a test; of a module that is skipped as a whole, its file."""
    path = file_of(module)
    if name == module:
        return str(path)
    classes = module.split(".")[len(path.parts) :]
    return "::".join([str(path), *classes, name])


def main(arguments):
    """Do what the arguments say; return the exit status."""
    if arguments[0] == "--tests":
        for test in sorted(node(*one) for one in skipped(arguments[1])):
            print(test)
        return 0
    found = skipped(arguments[-1])
    print(f"{len(found)} tests were skipped:")
    for reason, count in Counter(found.values()).most_common():
        print(f"  {count}: {reason}")
    if arguments[0] != "--none":
        return 0
    for (module, name), reason in sorted(found.items()):
        print(f"never run: {node(module, name)}: {reason}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

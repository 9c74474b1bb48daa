"""Source files that a module depends on, so that a job can declare them as its input.

Snakemake reruns a job when an input changes, but does not look into imported modules. A job has one
file for all of them: with dozens for each of thousands of jobs, a plan takes twice as long.
"""

import hashlib
import os
from functools import cache
from importlib import import_module
from pathlib import Path

import grimp

from vibrissa.files import write_atomically

PACKAGE = "vibrissa"
# The files of a web page belong to the package that they are in.
PAGE_SUFFIXES = (".html", ".css", ".js")
# Where the lists of sources are.
FOLDER = Path(".snakemake/code")


def sources_file(*modules: str) -> str:
    """Return a file that changes when the sources of some modules do, and write it if they did.

    Parameters
    ----------
    *modules : str
        As `sources` takes them.

    Returns
    -------
    str
        Path of a list of the sources and their digests; relative to the working directory if they
        are below it.

    Raises
    ------
    ValueError
        If there is no such module.
    OSError
        If the file cannot be written.
    """
    paths = sources(*modules)
    home = paths[0].parents[1]
    text = "".join(
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.relative_to(home)}\n"
        for path in paths
    )
    listed = FOLDER / f"{'-'.join(modules)}.txt"
    known = listed.is_file()
    if not known or listed.read_text(encoding="utf-8") != text:
        FOLDER.mkdir(parents=True, exist_ok=True)
        with write_atomically(listed) as temporary:
            temporary.write_text(text, encoding="utf-8")
        if not known:
            # What was made by these sources is not older than they are.
            youngest = max(path.stat().st_mtime_ns for path in paths)
            os.utime(listed, ns=(youngest, youngest))
    return str(listed if home.is_relative_to(Path.cwd()) else listed.absolute())


def sources(*modules: str) -> list[Path]:
    """Return the source files of some modules of the package, and of all that they import from it.

    Parameters
    ----------
    *modules : str
        Names of modules without the package's name, as in ``tables.store``.

    Returns
    -------
    list of Path
        In the order of their names. The files of a web page are among them.

    Raises
    ------
    ValueError
        If there is no such module.
    """
    graph = _imports(PACKAGE)
    wanted = {f"{PACKAGE}.{module}" for module in modules}
    if unknown := sorted(wanted - graph.modules):
        raise ValueError(f"no module {', '.join(unknown)}")
    found, new = set[str](), wanted
    while new:
        found |= new
        # Python imports the packages that a module is in, too, and what these import.
        parents = {m.rsplit(".", n)[0] for m in new for n in range(1, m.count(".") + 1)}
        imported = (graph.find_modules_directly_imported_by(module) for module in new)
        new = parents.union(*imported) - found
    return sorted(path for module in found for path in _files(module))


@cache
def _imports(package: str) -> grimp.ImportGraph:
    """Return the imports within a package, without those for type checkers alone."""
    return grimp.build_graph(package, exclude_type_checking_imports=True, cache_dir=None)


def _files(module: str) -> list[Path]:
    top, _, rest = module.partition(".")
    folder = Path(*import_module(top).__path__).joinpath(*rest.split("."))
    if not folder.is_dir():
        return [folder.with_suffix(".py")]
    below = [path for path in folder.iterdir() if path.is_dir() and not _is_package(path)]
    pages = [path for place in (folder, *below) for path in place.iterdir()]
    return [
        folder / "__init__.py",
        *(path for path in pages if path.suffix in PAGE_SUFFIXES),
    ]


def _is_package(folder: Path) -> bool:
    return (folder / "__init__.py").exists()

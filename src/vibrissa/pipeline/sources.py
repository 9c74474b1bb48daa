"""Source files that a module depends on, so that a job can declare them as its input.

Snakemake reruns a job when an input changes, but does not look into imported modules.
"""

from functools import cache
from importlib import import_module
from pathlib import Path

import grimp

PACKAGE = "vibrissa"
# The files of a web page belong to the package that they are in.
PAGE_SUFFIXES = (".html", ".css", ".js")


def sources(*modules: str) -> list[str]:
    """Return the source files of some modules of the package, and of all that they import from it.

    Parameters
    ----------
    *modules : str
        Names of modules without the package's name, as in ``tables.store``.

    Returns
    -------
    list of str
        Paths, relative to the working directory if they are below it. The files of a web page are
        among them.

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
    here = Path.cwd()
    paths = sorted(path for module in found for path in _files(module))
    return [str(path.relative_to(here) if path.is_relative_to(here) else path) for path in paths]


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

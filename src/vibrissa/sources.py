"""Source files that a module depends on, so that a job can declare them as its input.

Snakemake reruns a job when an input changes, but does not look into imported modules.
"""

import ast
from pathlib import Path

PACKAGE = Path(__file__).parent


def sources(*modules: str) -> list[str]:
    """Source files of some of this package's modules and of all that they import from it.

    Parameters
    ----------
    *modules : str
        Names of modules without the package's name.

    Returns
    -------
    list of str
        Paths, relative to the working directory where they lie below it, with the files of a web
        page that belong to a module: they have its name.

    Raises
    ------
    FileNotFoundError
        If there is no such module.
    """
    found: set[str] = set()
    pending = list(modules)
    while pending:
        module = pending.pop()
        if module not in found:
            found.add(module)
            pending += _imports(PACKAGE / f"{module}.py")
    paths = sorted(
        path
        for module in found
        for path in PACKAGE.glob(f"{module}.*")
        if path.suffix in (".py", ".html", ".css", ".js")
    )
    here = Path.cwd()
    return [str(path.relative_to(here) if path.is_relative_to(here) else path) for path in paths]


def _imports(path: Path) -> set[str]:
    """Modules of this package that a source file imports."""
    imported = set()
    pending: list[ast.AST] = [ast.parse(path.read_text(encoding="utf-8"))]
    while pending:
        node = pending.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue  # not imported when the code runs
        pending += ast.iter_child_nodes(node)
        if isinstance(node, ast.ImportFrom) and node.module:
            package, _, module = node.module.partition(".")
            if package == PACKAGE.name:
                imported |= {module} if module else {alias.name for alias in node.names}
    return {name for name in imported if (PACKAGE / f"{name}.py").exists()}

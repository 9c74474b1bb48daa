"""What Snakemake imports and a run does not use: it takes a third of the time to start.

Snakemake imports every plugin that is installed, looks through all installed packages for each kind
of plugin anew, and imports pandas to see whether the parameters of jobs are tables.
"""

import pkgutil
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from pkgutil import ModuleInfo
from typing import Any

# Plugins, and the word by which the arguments or the profile of a run would ask for them.
PLUGINS = {"snakemake_executor_plugin_slurm": "slurm", "snakemake_logger_plugin_rich": "rich"}
# With these, who knows where a plugin is asked for.
ELSEWHERE = {"--profile", "--executor", "-e"}
# The profile that Snakemake takes where it is in the working directory.
OWN_PROFILE = Path("profiles/default")


def unused(arguments: Sequence[str], environment: Mapping[str, str]) -> set[str]:
    """Return plugins that a run of Snakemake cannot use.

    Parameters
    ----------
    arguments : sequence of str
        Of Snakemake's command line.
    environment : mapping of str

    Returns
    -------
    set of str
        Names of packages; none where a profile of the user may ask for them.
    """
    words = [word for argument in arguments for word in argument.split("=", 1)]
    if "SNAKEMAKE_PROFILE" in environment or ELSEWHERE.intersection(words):
        return set()
    folders = [OWN_PROFILE, *(Path(word) for word in words)]
    texts = [path.read_text() for folder in folders for path in folder.glob("config*.yaml")]
    said = " ".join([*words, *texts])
    return {package for package, word in PLUGINS.items() if word not in said}


def leave_out(packages: Collection[str]) -> None:
    """Let this process see no such top-level packages where it looks for plugins."""
    every = [module for module in pkgutil.iter_modules() if module.name not in packages]
    look = pkgutil.iter_modules

    def iter_modules(path: Any = None, prefix: str = "") -> Iterator[ModuleInfo]:
        return look(path, prefix) if path is not None else iter(every)

    pkgutil.iter_modules = iter_modules


def compare_plain_params() -> None:
    """Let Snakemake, in this process, compare the parameters of jobs without pandas.

    They are texts, numbers, and lists and dicts of them.
    """
    from snakemake.persistence import PersistenceBase

    PersistenceBase._serialize_param_pandas = PersistenceBase._serialize_param_builtin

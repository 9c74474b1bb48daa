"""Dry runs of Snakemake in forked processes that have it loaded, which else takes two seconds.

This module imports nothing of the package, as a dry run may be of a copy of it.
"""

import os
import sys
from multiprocessing import get_context
from pathlib import Path

SERVER = get_context("forkserver")
# Snakemake, and what it and the package load later.
PRELOADED = ("snakemake.cli", "snakemake.workflow", "snakemake.profiles", "snakemake.storage")
PRELOADED += ("snakemake.report.html_reporter", "snakemake_logger_plugin_rich", "pydantic")
SERVER.set_forkserver_preload([*PRELOADED])


def dry_run(arguments, folder, home, screen):
    """Exit status of a dry run; its output goes to the file `screen`."""
    one = SERVER.Process(target=_run, args=(arguments, folder, home, screen, dict(os.environ)))
    one.start()
    one.join()
    return one.exitcode


def _run(arguments, folder, home, screen, variables):
    """Do what `python -m vibrissa.pipeline` does in its child."""
    source = str(Path(home, "src"))
    os.environ.clear()
    os.environ.update(variables, PYTHONPATH=source)
    os.chdir(folder)
    sys.path.insert(0, source)
    with open(screen, "w") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    from vibrissa.pipeline import child, places

    profile = ["--workflow-profile", str(places.HOME / "workflow/profiles/default")]
    sys.argv = ["snakemake", "--snakefile", str(places.SNAKEFILE), *profile, "-n", *arguments]
    child.main()

"""Workers: processes that run the scripts of jobs, forked from one that has imported everything.

Snakemake starts Python anew for the script of each job, and most of these jobs take less time than
their imports. Here a process imports once, when the first job is about to start, all that the
scripts import, and each job runs in a fork of it. Nothing else changes: logs, benchmarks, failures
and results are those of a Python of the job's own.
"""

import ast
import os
import runpy
import subprocess
import sys
from collections.abc import Iterator
from contextlib import nullcontext
from multiprocessing import get_context
from multiprocessing.connection import wait
from pathlib import Path
from threading import Lock
from typing import Any

from vibrissa.pipeline.places import HOME

SCRIPTS = HOME / "workflow/scripts"
# What Snakemake puts above each script, and what the scripts import late.
ALSO = (
    "snakemake.logging",
    "snakemake.iocontainers",
    "pandas",
    "pyarrow.dataset",
    "scipy.integrate",
    "matplotlib.backends.backend_pdf",
    "matplotlib.backends.backend_svg",
    "vibrissa.sticking.solving.collocation",
)
# Read when numerical libraries are loaded. A rule with more threads gets a Python of its own.
THREADS = ("OMP", "OPENBLAS", "MKL", "NUMEXPR")
_ONE_AT_A_TIME = Lock()


def modules_of(script: Path) -> Iterator[str]:
    """Yield the modules that the first lines of a script import.

    Parameters
    ----------
    script : Path
        Python file.

    Yields
    ------
    str
        A name that is imported from a package may be a module, or something else in it.
    """
    for statement in ast.parse(script.read_bytes()).body:
        match statement:
            case ast.Import(names=names):
                yield from (name.name for name in names)
            case ast.ImportFrom(module=str(module), names=names):
                yield module
                yield from (f"{module}.{name.name}" for name in names)


def install() -> None:
    """Let Snakemake, in this process, run the scripts of local jobs in workers.

    Jobs that ask for an environment, a container or several threads are run as before.
    """
    from snakemake.benchmark import benchmarked
    from snakemake.script import PythonScript

    context = get_context("forkserver")
    context.set_forkserver_preload([*ALSO, *_modules()])
    own_python = PythonScript.execute_script

    def execute_script(self: PythonScript, fname: str, edit: bool = False) -> None:
        if needs_its_own(self):
            own_python(self, fname, edit)
            return
        os.environ.update({f"{library}_NUM_THREADS": "1" for library in THREADS})
        worker: Any = context.Process(target=run, args=[fname], daemon=True)
        start(worker)
        record = self.bench_record
        with benchmarked(worker.pid, record) if record else nullcontext():
            status = exit_status(worker)
        if status:
            raise subprocess.CalledProcessError(status, [sys.executable, fname])

    PythonScript.execute_script = execute_script


def start(worker: Any) -> None:
    """Start a process, as several threads may do at the same time.

    Parameters
    ----------
    worker : multiprocessing.Process
    """
    with _ONE_AT_A_TIME:
        worker.start()


def exit_status(worker: Any) -> int:
    """Wait for a process that `start` has started.

    Whoever starts a process looks which others have ended, too. The status of a process can be read
    but once: of two threads that read it the second would get 255.

    Parameters
    ----------
    worker : multiprocessing.Process

    Returns
    -------
    int
        Negative where a signal ended it.
    """
    wait([worker.sentinel])
    with _ONE_AT_A_TIME:
        worker.join()
    return int(worker.exitcode)


def run(script: str) -> None:
    """Run a script in this process."""
    runpy.run_path(script, run_name="__main__")


def _modules() -> list[str]:
    return sorted({name for path in SCRIPTS.glob("*.py") for name in modules_of(path)})


def needs_its_own(script: Any) -> bool:
    """Whether a script of Snakemake cannot run in a worker."""
    return bool(
        script.conda_env
        or script.container_img
        or script.env_modules
        or script.shadow_dir
        or script.threads != 1
    )

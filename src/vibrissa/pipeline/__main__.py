"""Snakemake's own command line with the logger `vibrissa`, for `run`.

Snakemake finds a plugin by itself only if it is a package of its own at the top level.
"""

import logging
import os
import sys

from vibrissa.pipeline import events, lean, workers


def main() -> None:
    """Run Snakemake with the arguments of this process."""
    # It looks for plugins as it is imported.
    lean.leave_out(lean.unused(sys.argv[1:], os.environ))
    from snakemake.cli import main as snakemake
    from snakemake.logging import logger
    from snakemake_interface_logger_plugins.registry import LoggerPluginRegistry

    LoggerPluginRegistry().register_plugin("snakemake_logger_plugin_vibrissa", events)
    logger.addFilter(events.note_exception)
    lean.compare_plain_params()
    workers.install()
    # If Snakemake's log cannot be written, as on a full disk, a traceback for each line is no help.
    logging.raiseExceptions = False
    sys.argv[0] = "snakemake"
    snakemake()


main()

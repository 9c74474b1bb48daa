"""Snakemake's own command line with the logger `vibrissa`, for `run`.

Snakemake finds a plugin by itself only if it is a package of its own at the top level.
"""

import logging
import sys

from snakemake.cli import main
from snakemake.logging import logger
from snakemake_interface_logger_plugins.registry import LoggerPluginRegistry

from vibrissa.pipeline import events, workers

LoggerPluginRegistry().register_plugin("snakemake_logger_plugin_vibrissa", events)
logger.addFilter(events.note_exception)
# If Snakemake's log cannot be written, as on a full disk, a traceback for each line is no help.
logging.raiseExceptions = False
workers.install()
sys.argv[0] = "snakemake"
main()

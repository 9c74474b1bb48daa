"""The command line: a file for each command.

Reads arguments and files, calls the package, writes results; it decides nothing.
"""

from typing import Any

# Settings of every command, and of a command in its own file.
HELP: dict[str, Any] = {"help_option_names": ["-h", "--help"]}
ALONE: dict[str, Any] = {"add_completion": False, "rich_markup_mode": "markdown"}

"""A study as one file for publication, an RO-Crate, and whether an unpacked one is as it was."""

from vibrissa.extras import require

require("workflow", "rocrate", "yaml")

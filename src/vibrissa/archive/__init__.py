"""A study as one file for publication, an RO-Crate, and whether it makes its results again."""

from vibrissa.extras import require

require("workflow", "pyarrow", "rocrate", "yaml")

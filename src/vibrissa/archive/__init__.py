"""Archive of a study as one file for publication (RO-Crate), and its verification."""

from vibrissa.extras import require

require("workflow", "rocrate", "yaml")

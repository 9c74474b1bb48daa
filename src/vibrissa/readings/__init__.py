"""Readings: friction read from simulated recordings of scans, as a table."""

from vibrissa.extras import require

require("tables", "pandas", "pyarrow")

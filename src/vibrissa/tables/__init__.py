"""The tables: what their columns are, results as rows, their files, and how rows are read."""

from vibrissa.extras import require

require("tables", "pandas", "pyarrow")

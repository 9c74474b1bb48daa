"""Tables of a study: their columns, rows, files, and queries."""

from vibrissa.extras import require

require("tables", "pandas", "pyarrow")

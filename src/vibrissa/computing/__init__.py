"""Computing a study: the rows of its tables, from its chunks, single states and comparisons."""

from vibrissa.extras import require

require("tables", "pyarrow")

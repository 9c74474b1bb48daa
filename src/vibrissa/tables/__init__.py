"""The tables: their schemas, their files, results as rows, and many files as one table.

Knows the results of `vibrissa.sticking` and the keys of `vibrissa.study`.
"""

from vibrissa.extras import require

require("tables", "pandas", "pyarrow")

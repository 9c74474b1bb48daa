"""What moved: results against reference tables, and two results folders side by side.

A results folder is condensed to a few tables with one row for each key, and these are compared as
text, row by row. Knows the tables, and not how they are made.
"""

from vibrissa.extras import require

require("workflow", "matplotlib", "pandas", "pyarrow", "yaml")

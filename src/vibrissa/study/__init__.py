"""The study file: what may stand in it, its grids of exact decimals, what they cost.

Light enough for a Snakefile: no NumPy, no solver.
"""

from vibrissa.extras import require

require("workflow", "pydantic", "yaml")

"""Figures, drawn from the tables alone.

A kind of figure is one function with the decorator `vibrissa.figures.kinds.kind`, in the module of
its family; `vibrissa.study.figures` declares its keys and its table. Lengths are in units of L.
"""

from vibrissa.extras import require

require("plots", "matplotlib")

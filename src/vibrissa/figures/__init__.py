"""Figures, drawn from the tables alone.

A kind of figure is one function with the decorator `vibrissa.figures.kinds.kind`, in the module of
its family; `vibrissa.figures.draw` lists the families. `vibrissa.study.figures` declares, for each
kind, its keys in the study file and the table that it is drawn from. A drawing function knows the
rows of that table and `vibrissa.figures.style`, and no file. Lengths are in units of the rod's
length L.
"""

from vibrissa.extras import require

require("plots", "matplotlib")

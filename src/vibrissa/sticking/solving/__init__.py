"""Equilibrium paths are solved: by collocation, and by the paper's own shooting as a check.

`collocation` follows paths from α = 0 (`beginning`, `following`), cuts them into
smooth `sections` and resolves these (`refinement`, `finishing`). What is solved is put together in
`vibrissa.sticking.assembly`.
"""

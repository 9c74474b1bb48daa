"""Equilibrium paths are solved: by collocation, and by the paper's own shooting as a check."""

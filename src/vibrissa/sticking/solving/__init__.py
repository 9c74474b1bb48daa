"""Solvers of equilibrium paths: collocation, and the paper's own shooting as a check."""

"""Mechanics of one rod in contact: geometry, equilibrium, stability, bending, admissible shapes."""

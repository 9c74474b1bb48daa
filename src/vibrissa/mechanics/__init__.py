"""Mechanics of one rod in contact: geometry, equilibrium, stability, bending, admissible shapes.

Knows states, not how they follow one another; no files.
"""

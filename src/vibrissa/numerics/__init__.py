"""Numerical methods: array types, spectral bases, roots, the step grid.

Knows nothing of rods.
"""

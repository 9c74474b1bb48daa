"""Numerical methods: array types, spectral bases, roots, the step grid.

Independent of rods.
"""

"""Numerical methods: arrays, batches, eigenvalues, roots, spectral bases, the step grid.

No module here depends on the mechanics of rods.
"""

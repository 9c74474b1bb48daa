"""Periods of sticking: equilibrium paths, followed, resolved and read off for friction.

Knows how states of `vibrissa.mechanics` follow one another while the clamp moves; no files.
"""

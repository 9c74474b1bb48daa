"""Periods of sticking: equilibrium paths, followed, resolved and read off for friction.

`solving` solves the paths, `assembly` puts curves together from them, and `reading` asks for places
on them. Knows how states of `vibrissa.mechanics` follow one another while the clamp moves; no
files.
"""

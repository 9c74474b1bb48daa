"""Periods of sticking: equilibrium paths, and where sticking ends on them for given friction.

`solving` computes the paths, `assembly` makes sticking curves of them, and `reading` evaluates
states and onsets of slip on the curves.
"""

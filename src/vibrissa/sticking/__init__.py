"""Periods of sticking: equilibrium paths, and where sticking ends on them for given friction.

`solving` computes the paths, `locks` makes sticking curves of them with their ends and locks,
`evaluation` evaluates states and onsets of slip on the curves, and `periods` counts steps.
"""

"""Periods of sticking: equilibrium paths, and where sticking ends on them for given friction.

`solving` computes the paths, `locks` makes sticking curves of them with their ends and locks,
`curve` evaluates states on a curve, `onsets` finds onsets of slip on many curves, and `periods`
counts steps.
"""

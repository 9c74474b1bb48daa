"""Periods of sticking: equilibrium paths, followed, resolved and read off for friction.

`solving` solves the paths, `assembly` makes curves of them, `reading` reads states and onsets off.
"""

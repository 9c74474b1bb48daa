"""Periods of sticking: equilibrium paths, followed, resolved and read off for friction.

`solving` solves the paths, `assembly` puts curves together, and `reading` asks for places on them.
"""

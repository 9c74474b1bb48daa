"""The study file: its sections, axes and figures, and the chunks in which its points are solved.

Light enough for a Snakefile: nothing here computes.
"""

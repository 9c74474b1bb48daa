"""The study file: its sections, axes and figures, and the chunks in which its points are solved.

A Snakefile can import this package quickly, because no module here solves anything.
"""

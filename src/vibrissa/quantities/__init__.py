"""Quantities with units: in texts, in set-up files and options, and in tables."""

"""Scans: where the tip sticks and slips on a surface, on a level and on an oblique stage."""

"""Simulated scans: where the tip sticks and slips, on a level or an oblique stage."""

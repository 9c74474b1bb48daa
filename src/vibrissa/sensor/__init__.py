"""The sensor: from a surface to signals at the clamp, and from signals back to friction."""

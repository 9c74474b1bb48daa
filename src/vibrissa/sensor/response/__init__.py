"""Clamp reactions as functions of the displacement x0, for one height or a range of heights."""

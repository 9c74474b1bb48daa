"""Clamp reactions as functions of the displacement x0, at one height or over a range."""

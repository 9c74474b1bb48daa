"""Identification of the friction of each period of sticking from a recording."""

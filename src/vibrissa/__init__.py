"""Vibrissa: a whisker-like tactile sensor that sticks to a surface and slips.

Each public name is imported from its module when it is first used.
"""

import lazy_loader

__version__ = "1.0.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

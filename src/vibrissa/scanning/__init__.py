"""Scans: the clamp moves over a surface in steps, and the tip sticks and slips.

The public names are imported when first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

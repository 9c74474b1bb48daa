"""Identification of friction from signals of the clamp, and signals of simulated scans.

The public names are imported when first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

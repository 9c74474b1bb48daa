"""Design of the rod of a sensor: requirements, constraints, materials and the search.

The command line calls `design`. This package builds on `vibrissa.sensor`. The public names are
imported when first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

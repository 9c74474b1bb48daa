"""The strip: one sheet with the loads of a recording, and the friction along the surface."""

from vibrissa.extras import require

require("plots", "matplotlib")

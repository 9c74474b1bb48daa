"""From a recording to the friction of each period of sticking, and how well it is known.

A force sample goes once through these modules: `recording` (file to samples), `periods` (state of
the rod, cut into periods), `friction` (the friction of each period, by one of the `methods`, with
`uncertainty`, `spacing` and `energy`); `calibration` comes before if height or offsets are unknown,
`doubts` after.
"""

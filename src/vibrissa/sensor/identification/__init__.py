"""From a recording to the friction of each period of sticking, and how well it is known.

A force sample goes once through these modules: `recording` (file to samples), `periods` (state of
the rod, cut into periods), `sides` (ahead of the clamp or behind it), `seen` (the periods with
their contacts), `friction` (what is known of each, read by one of the methods in `reading`).
`calibration` comes before if height or offsets are unknown, `misfit` after: it tells what does not
fit, by `alternatives` to what was given. `summary` says in a few lines what came out.
"""

"""From a recording to the friction of each period of sticking, and how well it is known.

A force sample goes once through these modules: `recording` (file to samples), `periods` (state of
the rod, cut into periods), `part` (what fits, up to where the rod buckles laterally), `seen` (the
periods with their contacts), `friction` (what is known of each). `adjusting` comes before: it fits
the set-up within its tolerances; `misfit` after: it tells what does not fit, by `alternatives` to
what was given. `without_rod` reads the ratio of the forces. `summary` says in a few lines what came
out.
"""

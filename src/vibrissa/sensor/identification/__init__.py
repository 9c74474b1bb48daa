"""From a recording to the friction of each period of sticking, and how well it is known.

`recording` reads a file, `task` puts together what is known of it, `slips` finds the periods. Then
`model` fits set-up and contacts through the rod (`forward`, `fit`; `friction` reads the onsets,
`goodness` tells what may be other than given), or `ratio` reads the ratio of the forces (`onsets`).
`compare` puts both beside each other, `summary` says in a few lines what came out.
"""

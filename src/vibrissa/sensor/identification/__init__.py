"""From a recording to the friction of each period of sticking, and how well it is known."""

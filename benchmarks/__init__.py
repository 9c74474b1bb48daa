"""How fast states are found, and how studies grow."""

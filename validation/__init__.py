"""Long checks of the program, which a study does not need: `python -m validation --list`."""

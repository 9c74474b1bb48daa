"""What does not fit the rod: a period by itself, the recording as a whole, mixed-up columns."""

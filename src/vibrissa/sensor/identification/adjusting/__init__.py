"""What was given, adjusted to a recording within its tolerances."""

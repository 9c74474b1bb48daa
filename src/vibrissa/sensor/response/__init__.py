"""Load on the clamp over its displacement, pushed or pulled, at one height or over a range."""

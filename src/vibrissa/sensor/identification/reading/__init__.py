"""From the last sticking state of each period to its friction, by a class for each method."""

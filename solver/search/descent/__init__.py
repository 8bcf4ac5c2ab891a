"""The way down to a minimum, and the points that its surroundings are told by."""

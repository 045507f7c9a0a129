"""Statistics of the readings of one stretch of a log."""

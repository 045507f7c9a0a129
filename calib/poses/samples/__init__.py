"""What the readings of one stretch of a log show."""

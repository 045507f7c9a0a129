"""Whether readings are measurements, and a stretch of them a pose."""

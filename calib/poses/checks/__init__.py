"""Tests whether readings are measurements, and whether a stretch of them is a pose."""

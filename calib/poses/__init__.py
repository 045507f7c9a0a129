"""Readings to poses."""

"""Composes vision and calib: files, YAML, screen."""

__version__ = "0.1.0"

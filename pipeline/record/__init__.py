"""Guided recording: the serial line, the poses, the folder they are kept in."""

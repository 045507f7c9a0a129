"""``python -m pipeline``."""

from pipeline.cli import program

program()

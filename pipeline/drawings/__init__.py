"""Drawings: of a sensor's box in a pose, in SVG and on a terminal, and charts in SVG."""

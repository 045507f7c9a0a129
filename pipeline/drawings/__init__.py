"""Drawings of a sensor's box in its poses: as lines, for a terminal, and as a sheet in SVG.

    box ─┬─ terminal
         └─ sheet
    svg ─┬─ bench (plate, marks, camera, wedge)
         └─ leaning_player (a book under one side)
"""

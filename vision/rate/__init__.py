"""A phase track to a rate with its uncertainty. NumPy only; no OpenCV.

    timebase, aliases ─ unwrap ─ jumps ─ dropped_frames ─ terms (least_squares) ─ measure
                                   stability, wow_flutter ───────┤
                                other_rates ─ cross_checks ──────┤
                                                diagnosis ───────┘
"""

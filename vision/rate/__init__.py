"""A phase track to a rate with its uncertainty. NumPy only; no OpenCV.

    unwrap ─ aliases ─ terms (least_squares, timebase) ─ measure
    cross_checks, stability ───────────────────────────────┤
    wow_flutter, diagnosis ────────────────────────────────┘
"""

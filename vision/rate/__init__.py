"""A phase track to a rate with its uncertainty. NumPy only; no OpenCV.

    unwrap ─ aliases ─ terms, line_fit (least_squares, timebase) ─ measure
    frame_count, autocorrelation ─ cross_checks ───────────────────┤
    stability, camera_roll ─ warnings ─────────────────────────────┤
    wow_flutter, diagnosis ────────────────────────────────────────┘
"""

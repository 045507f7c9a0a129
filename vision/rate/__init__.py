"""A phase track to a rate with its uncertainty. NumPy only; no OpenCV.

    timebase, unwrap ─ aliases ─ steady_part ─ stability ─ jumps ─ dropped_frames ─┐
    least_squares ─ terms, transients ─ wow_flutter, diagnosis ────────────────────┼─ measure
    other_rates ─ cross_checks, exposure ──────────────────────────────────────────┘
"""

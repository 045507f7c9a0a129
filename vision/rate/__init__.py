"""A phase track to a rate with its uncertainty. NumPy only; no OpenCV.

    timebase, unwrap ─ slow_camera, steady_part ─ aliases, stability ─ jumps ─ dropped_frames ─┐
    least_squares ─ terms, transients ─ diagnosis, aes6_flutter ───────────────────────────────┤
    other_rates ─ cross_checks, exposure ────────────────────────────────────────────── measure
"""

"""From a phase track to a rate with its uncertainty. NumPy only; no OpenCV.

    timebase, unwrap ─ angle_levels ─ slow_camera ─ aliases ─ dropped_frames ─┐
    cross_checks ─────────────────────────────────────────────────────── seen ─ checks ─┐
    least_squares ─ terms, steady_part ─ diagnosis, exposure, camera_roll ──────── measure
    measure ─ aes6_flutter
"""

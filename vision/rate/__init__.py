"""From a phase track to a rate with its uncertainty. NumPy only; no OpenCV.

    timebase, unwrap ─ angle_levels ─ slow_camera ─ aliases ─ dropped_frames ─┐
    least_squares ─ terms ─ slow_changes ─ steady_part ────────────────── checks ─┐
    cross_checks, diagnosis, exposure, camera_roll ──────────────────────────────── measure
    measure ─ aes6_flutter
"""

"""Frames and a learned plate to the plate's angle in every frame.

    tracker ─ frame_measurement ─ track ─ PhaseTrack
    camera_motion ───────┘           └─ annotate (one frame with all that was found)
"""

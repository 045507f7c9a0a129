"""Frames and a learned plate to the plate's angle in every frame.

    frames ─ stretch ─ registration ─ tracker ─ frame_measurement ─ track ─ PhaseTrack

``stretch``: the frames to learn from. ``registration``: whether the camera moves, and its frames
brought back. ``tracker``: plate angle against the template. ``frame_measurement``: what is measured
in a frame. ``track``: the clip in one pass.
"""

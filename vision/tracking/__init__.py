"""Frames and a learned plate to the plate's angle in every frame.

    frames ─ stretch ─ registration ─ tracker ───────┬─ frame_measurement ─ track ─ PhaseTrack
                                      camera_motion ─┘

``stretch``: the frames to learn from. ``registration``: frames of a camera that moves, brought
back. ``tracker``: plate angle against the template. ``camera_motion``: roll of the camera.
``frame_measurement``: what is measured in a frame, and the annotated frame. ``track``: the clip in
one pass.
"""

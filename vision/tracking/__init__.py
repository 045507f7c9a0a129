"""From frames and a learned plate to the plate's angle in every frame.

    frames ─ stretch ─ registration ─ tracker ─ frame_measurement ─ track ─ PhaseTrack

``stretch``: the frames to learn from. ``registration``: motion of the camera, and its removal from
the frames. ``roll_gauge``: the roll of the camera that is left. ``tracker``: plate angle against
the template. ``frame_measurement``: the measurements of a frame. ``track``: the clip in one pass.
``best_track``: the choice among several methods.
"""

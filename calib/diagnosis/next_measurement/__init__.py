"""The poses that would settle what these leave open.

    pose_blocks (hypothetical rows beside the real ones) ─ advice (the block worth its time)
"""

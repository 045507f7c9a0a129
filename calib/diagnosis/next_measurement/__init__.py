"""The poses that would settle what these leave open.

    ideal_poses (readings of a perfect sensor)
        └─ pose_blocks (hypothetical rows beside the real ones) ─ advice (the block worth its time)
"""

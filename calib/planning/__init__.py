"""What poses determine before they are recorded.

    ideal_poses (what a perfect sensor would read) ─► prospect (sds, what stays unseen, what next)
"""

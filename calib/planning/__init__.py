"""Expected results of planned poses, before they are recorded.

    ideal_poses (readings of a perfect sensor) ─► prospect (sds, blind effects, next pose)
"""

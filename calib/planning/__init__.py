"""Expected results of planned poses, before they are recorded.

    prospect (sds, blind effects, next pose), of the readings of a perfect sensor in them
"""

"""A stored calibration for other programs, and applied to a log.

    parts ─ plain, robotics, firmware ─ formats ─ write        apply: counts to SI units
"""

"""Mounting of the sensor in a vehicle: Promrit et al.

    still_reading ─ levelling (roll, pitch) ─┬─ floor_slope ─ mounting
    heading (yaw, from a drive) ─────────────┘
"""

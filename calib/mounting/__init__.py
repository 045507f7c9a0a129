"""How the sensor is mounted in a vehicle: Promrit et al.

    still_reading ─ levelling (roll, pitch) ─┬─ mounting
    heading (yaw, from a drive) ─────────────┤
    floor (slope, from the reverse heading) ─┘
"""

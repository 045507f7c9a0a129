"""How the sensor is mounted in a vehicle: Promrit et al.

    still_reading ─ levelling (roll, pitch), both_orders ─ mounting
"""

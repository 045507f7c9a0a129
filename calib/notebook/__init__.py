"""A calibration in a few lines of Python, by the same engine as the command.

    table ─ tables ─ PoseSet ─ calibration (fit, diagnosis, prediction) ─ display
                        └─ from_table: one sensor, or many side by side
"""

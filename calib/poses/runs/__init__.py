"""Averaged poses and what they are measured against.

    ring (all round one turn of a plate that leans) ─ pose_run ─ reference_runs ─ tilted_run
"""

"""Averaged poses and their references.

    ring (all round one turn of a plate that leans) ─ pose_run ─ reference_runs ─ ideal_ring
"""

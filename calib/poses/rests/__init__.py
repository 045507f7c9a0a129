"""The rests of a long log.

    still_search (what a user says of it) ─ rest_candidates ─ attitude_fit ─ static_intervals
"""

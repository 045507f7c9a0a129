"""What many sensors show and one cannot.

    evidence (one fit) ─ lot (side by side) ─ pool (what is missing in the lot)
    random_effects ─ spread (each parameter over the lot, sensors unlike it), repeatability
"""

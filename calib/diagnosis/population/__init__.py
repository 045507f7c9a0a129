"""Results that many sensors show and one cannot.

    evidence (one fit) ─ lot (side by side) ─ pool (effects that the lot lacks)
    random_effects ─ spread (each parameter over the lot, sensors unlike it, and that moved)
"""

"""A fit and its residuals to a verdict: what does the model miss?

    signature ─┬─ hypotheses ─ unlisted ─┐
    evidence ──┴──────────────── table ──┼─ sets ─ search ─ odds ─┬─ verdict ─ explain ─ diagnose
                                 refit ──┘                        └─ ranking  (wording)   │
                                                    pose_blocks ─ next_measurement ───────┘

``constants`` holds every number that is decided by.
"""

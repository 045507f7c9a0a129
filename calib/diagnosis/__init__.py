"""A fit and its residuals to a verdict: what does the model miss?

    signature ─ evidence ─ hypotheses ─ ranking ─ refit ─ verdict ─ diagnose
                                                             ├─ next_measurement ─ pose_blocks
                                                             └─ explain (the verdict in words)
"""

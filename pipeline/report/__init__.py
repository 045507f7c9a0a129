"""The outcome of a run as one self-contained page.

    summary, tables, pose_charts, rate_charts, history_chart (svg) ─────────┐
    refitted (exact fits of other models) ─ refit_table (the tick boxes) ───┴─ page ─ outputs
"""

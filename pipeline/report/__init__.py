"""The outcome of a run as one self-contained page.

    summary, tables, pose_charts, rate_charts, history_chart (svg) ─┐
    added_variable ─ refit_data (the tick boxes) ───────────────────┴─ page ─ outputs
"""

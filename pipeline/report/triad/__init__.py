"""A triad on the page: its poses, where the model fails, the effects, and fits with others.

    pose_charts, pose_sphere                    tables, history_chart
    refitted (exact fits of other models) ─┬─ refit_table (the tick boxes)
    drivers ─ partial_residuals ───────────┼─ axis_charts (where the model fails)
                                           └─ fingerprint ─ effect_cards
"""

"""A triad on the page: its poses, where the model fails, the effects, and fits with others.

    charts, pose_sphere                         tables
    refitted (exact fits of other models) ─┬─ refit_table (the tick boxes)
    drivers ─ partial_residuals ───────────┼─ axis_charts (where the model fails)
                                           └─ fingerprint ─ effect_cards
"""

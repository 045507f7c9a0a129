"""Text output of commands: one module for each kind of result.

    run_text ─ answers (what is good, wrong, next)        parameter_text, model_change_text
    rate_text, flutter_text, clock_text, noise_text       check_text, import_text, plan_text
    comparison_text, discovery_text, effect_pages         terminal: how lines are shown
"""

"""What commands print: one module for each kind of outcome.

    run_text, check_text, rate_text, plan_text, model_change_text, effect_pages,
    mounting_text, certificate_text
"""

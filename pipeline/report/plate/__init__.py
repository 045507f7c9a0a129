"""A plate setting on the page: rate, phase, terms, and how evenly the platter turns.

    rate_terms (the tick boxes) ─┬─ rate_charts
    speed_charts (`rate --page`) ┘
"""

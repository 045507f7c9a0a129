"""A plate setting on the page: rate, phase, terms, and the evenness of its rotation.

    rate_terms (the tick boxes) ─┬─ rate_charts
    speed_charts (`rate --page`) ┘
"""

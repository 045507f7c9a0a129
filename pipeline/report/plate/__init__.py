"""A plate setting on the page: rate, phase, terms, and how evenly the platter turns.

    rate_terms (the tick boxes) ─ term_sizes ─┐
    speed_charts ─────────────────────────────┴─ rate_charts          speed_page (`rate --page`)
"""

"""The named effects, the ranking, and the words of a verdict.

    decision (the verdict's code and names) ─┬─ explain (in words, with the next step)
                 ranking (every hypothesis) ──────────────┘  wording (names and odds in words)
"""

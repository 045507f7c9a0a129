"""What is named, how it ranks, and how it is said.

    decision (the verdict's code and names) ─┬─ explain (in words, with the next step)
                 ranking (every hypothesis) ──────────────┘  wording (names and odds in words)
"""

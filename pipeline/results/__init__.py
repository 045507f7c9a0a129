"""results.json and the history: written and read.

    rate, triad, mounting, certificate ─ write ─ results.json ─ read
                                           └─ history
"""

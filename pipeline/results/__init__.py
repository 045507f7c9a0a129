"""Reading and writing of results.json and the history.

    rate, triad, mounting, certificate ─ write ─ results.json ─ read
                                           └─ history
"""

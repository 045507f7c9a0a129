"""Pages for this computer's own browser: a server on the loopback address and its guard.

    guard ─ answers ─ serve
"""

"""Results to expect from the poses of a configuration, recorded and missing.

    settings (what is recorded of each, what is missing) ─► outlook (of every triad)
"""

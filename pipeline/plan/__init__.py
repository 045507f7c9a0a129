"""What the poses of a configuration determine, recorded and still to come.

    settings (what is recorded of each, what is missing) ─► outlook (of every triad)
"""

"""A renderer of clips as people film them, for ``tests.bench.clip_study``.

    art ─ stage ─ footage ─ shots

It shares nothing with ``vision`` and nothing with ``tests.world``: a disc and a table stand in
three dimensions before a pinhole camera, each moment of the exposure is a perspective warp of a
drawing, light adds up linearly and is encoded by a gamma curve. ``art``: what the disc and the
table look like. ``stage``: where the camera is. ``footage``: a shot as frames in a file. ``shots``:
the categories.
"""

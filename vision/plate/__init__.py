"""Position and appearance of the plate, learned from the first frames of a clip.

    channel, background ─ detect ─ rotation ─ alignment ─ learning_frames ─ choice ─ learn
              low_orders, window_rate ┘ parts ┘     │                    mark ─┘ └─ refusal
                             polar ─ template, view_refinement, inertia

``channel``: the measured quantity of a frame. ``background``: the stationary part. ``detect``:
ellipses that may be a rim. ``rotation``: whether something turns about their axis, and how fast,
from ``low_orders`` of the angle in windows of time (``window_rate``). ``parts``: the same for a
pattern that repeats around the plate. ``polar``: frames along rings. ``template``: the appearance
of the plate at rest. ``alignment``: template, angles and view together. ``inertia``: frames that
show their angle. ``view_refinement``: position of the axis. ``learning_frames``: templates of an
outline. ``evidence``: the test for rotation. ``choice``: the spindles of outlines, and the choice
of the plate among them. ``mark``: the mark and the symmetry. ``learn``: from frames to the
``PlateModel``. ``refusal``: the messages if there is no plate.
"""

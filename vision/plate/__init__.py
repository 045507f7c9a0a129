"""Where the plate is and what it looks like, learned from the first frames of a clip.

    channel, background ─ detect ─ rotation ─ alignment ─ learning_frames ─ choice ─ learn
              low_orders, window_rate ┘ parts ┘     │                    mark ─┘ └─ refusal
                             polar ─ template, view_refinement, inertia

``channel``: what of a frame is measured. ``background``: what stands still. ``detect``: ellipses
that may be a rim. ``rotation``: whether something turns about their axis, and how fast, from
``low_orders`` of the angle in windows of time (``window_rate``). ``parts``: the same of a pattern
that repeats around the plate. ``polar``: frames along rings. ``template``: the plate as it would
look standing still. ``alignment``: template, angles and view together. ``inertia``: which frames
show their angle. ``view_refinement``: where the axis is. ``learning_frames``: templates of an
outline. ``evidence``: what is believed to turn. ``choice``: the spindles of outlines, and which of
them is the plate. ``mark``: the mark and the symmetry. ``learn``: from frames to the
``PlateModel``. ``refusal``: the messages where there is no plate.
"""

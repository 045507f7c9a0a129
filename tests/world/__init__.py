"""A simulated bench: what the calibration is tested against, sharing no formula with it.

- ``bench`` (site, turntable, poses, evening) and ``imu`` (the sensor) state an experiment.
- ``designs`` names the usual ones, ``physics`` lives through one.
- ``hidden`` adds what a model may miss, ``sizes`` draws how much.
- ``session`` gives logs as arrays, ``write`` as files, ``truth`` what a perfect calibration finds.
- ``lot`` draws thousands of sensors at once, as pose means.
- ``plate``, ``scene``, ``picture``, ``film`` make the clips.

For example::

    effect = draw_effect("g_sensitivity", "gyroscope", 5.0, design := rich_design(), seed := 1)
    session = simulate(design, seed, (effect,))
"""

"""From a clip of a turning plate to its angular rate.

Conventions, everywhere in this package
---------------------------------------
Pixels
    ``(x, y)``, x to the right, y down; the centre of the top left pixel is (0, 0). Sizes and
    positions are in pixels of the analysed frame (a large clip is reduced by a whole factor).
Plate coordinates
    ``(u, v)`` in the plane of the plate, spindle at (0, 0), v upwards in an untilted frame.
Angles
    Radians; positive is counter-clockwise as filmed.
Time
    Seconds, from the first frame of the clip, as the container states it.

Modules
-------
``video``         a clip as luma frames with their time stamps
``orientation``   how a file wants its frames turned and mirrored
``colour``        what is followed of a frame: its brightness, or an axis of colour
``geometry``      the view: plate coordinates to pixels and back
``stillness``     what does not move, and where something does
``spin``          whether and how fast something turns about a proposed axis
``grid``          polar sampling of a frame about the spindle
``outline``       where a plate may be: ellipses of edges and of a moving mark
``template``      the plate as it would look standing still
``distortion``    how wrong the view is, from the plate's own motion
``symmetry``      how many times per turn the plate looks the same
``refusal``       what is said where no plate can be learned
``learn``         chooses among the proposals and learns the plate
``mark``          the mark on the plate, its centroid, and the fixed mark beside the plate
``follow``        plate angle of one frame after the other, against the template
``phase_track``   the result of all that: arrays only
``surroundings``  the roll of the camera, from what lies around the plate
``rows``          what is measured in every frame
``annotate``      one frame with plate, centre and marks drawn in
``track``         ``track_phase``: film to ``PhaseTrack``
``timebase``      which clock the rate is measured against
``motion``        continuous angle, lost frames, rate from turn to turn
``aliases``       rates that give the same frames, and the choice among them
``steadiness``    steady, drifting or stopping
``terms``         what a phase track may hold besides a constant rate
``regression``    least squares with honest standard deviations
``fit``           the line, and what is always fitted together with it
``counting``, ``lags``, ``opinions``
                  three more ways to the rate, and whether they agree
``camera_roll``   what a camera that rolls does to the rate
``cautions``      what is said beside a rate that stands all the same
``speed``         wow, flutter and drift
``diagnosis``     which term the stated model misses
``rate``          ``measure_rate``: ``PhaseTrack`` to ``RateMeasurement``

``rate`` and what it imports are NumPy alone; OpenCV is needed up to ``track``.
"""

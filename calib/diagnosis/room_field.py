"""Aliases of a g-sensitivity that rests on the waves of one leaning plate.

Gravity rotates in the sensor's axes once per turn, and so does everything fixed in the room: the
magnet of a motor makes the waves of a g-sensitivity in every pose. If the player leans the other
way, gravity's waves change sign relative to the room, and those of a field do not.
"""

from dataclasses import replace

from calib.diagnosis.diagnose import Diagnosis
from calib.fit.least_squares.result import Fit

GRAVITY_SENSED = "g_sensitivity"
TEXT = (
    " It rests on waves that keep step with the plate, and a field that stays in the room, as of a "
    "motor's magnet, makes the same ones: the same poses with the other side of the record player "
    "raised, or with the plate stopped, tell them apart."
)


def beside_a_field(diagnosis: Diagnosis, fit: Fit) -> Diagnosis:
    """``diagnosis`` with the alternatives to a g-sensitivity that it names.

    Parameters
    ----------
    diagnosis : Diagnosis
    fit : Fit
        Of a gyroscope; one run of poses on a leaning plate, and none at rest, cannot tell.
    """
    poses = fit.poses
    if poses.ring is None or GRAVITY_SENSED not in diagnosis.names:
        return diagnosis
    runs = {poses.run[place] for place in poses.ring.place}
    if len(runs) > 1 or poses.reference.is_null.any():
        return diagnosis
    said = diagnosis.explanation
    return replace(diagnosis, explanation=replace(said, text=said.text + TEXT))

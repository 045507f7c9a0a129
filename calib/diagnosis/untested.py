"""The verdict on poses whose noise is not known: the model cannot be tested by its own residual."""

from dataclasses import replace

from calib.diagnosis.diagnose import Diagnosis
from calib.diagnosis.verdict.decision import Code
from calib.diagnosis.verdict.explanation import Explanation

TEXT = (
    "Whether something is missing cannot be determined: the poses have no sds, and no attitude was "
    "repeated often enough to estimate their noise, so that whatever the model misses counts as "
    "noise. The ranking shows which effect would lower the leave-one-out error. State the sds of "
    "the means, use the logs that they come from, or record every pose twice."
)


BY_THE_REST = (
    " The poses have no sds: what the named effect leaves in the residual is taken for their noise."
)


def untested(diagnosis: Diagnosis) -> Diagnosis:
    """A diagnosis with sds that do not test the model.

    Parameters
    ----------
    diagnosis : Diagnosis

    Returns
    -------
    Diagnosis
        An effect that the residual shows whatever its noise stays named. Else it has no verdict;
        ranking, limits and blind effects stay.
    """
    if diagnosis.verdict == Code.EFFECT:
        told = diagnosis.explanation
        return replace(diagnosis, explanation=replace(told, text=told.text + BY_THE_REST))
    return replace(
        diagnosis,
        verdict=Code.REFUSED,
        name=None,
        names=(),
        group=(),
        inclusion=(),
        advice=None,
        explanation=Explanation("open", "its model cannot be tested", TEXT, "record",
                                "State the sds of the means, or record every pose twice"),
    )

"""What the program says of a log, and its calibration applied by the published formula alone."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calib.errors import Undetermined
from calib.fit.least_squares.solver import fit
from calib.fit.triad.calibration import calibrate_triad
from calib.fit.validation.prediction import Prediction, predict
from calib.poses.attitudes import direction_name
from calib.poses.imu_log import AXES, FloatArray
from pipeline.config.load import parse_config
from pipeline.stages.context import RunContext
from pipeline.stages.run import Outcome, run_stages
from pipeline.stages.triads import TriadResult
from tests.studies.real_sets import pose_means
from tests.studies.real_sets.logs import Log
from tests.studies.real_sets.turntable import CONFIGURATION


@dataclass(frozen=True, eq=False)
class Said:
    """One session: both triads, None where the program refused, with the reason."""

    accelerometer: TriadResult | None
    gyroscope: TriadResult | None
    refusal: str = ""


def ask(log: Log) -> Said:
    """Run the stages of the program on ``log``; nothing is written."""
    text = log.configuration()
    try:
        outcome = _run(text)
    except Undetermined as error:
        alone = text[: text.index("accelerometer:\n")] + text[text.index("gyroscope:\n") :] if (
            log.gyroscope) else None
        return Said(None, None if alone is None else _run(alone).triad("gyroscope"), str(error))
    return Said(outcome.triad("accelerometer"), outcome.triad("gyroscope"))


def ask_turntable() -> TriadResult:
    """The program on the gyroscope of the record player."""
    result = _run(CONFIGURATION).triad("gyroscope")
    assert result is not None
    return result


def ask_means() -> TriadResult:
    """The program on a table of pose means."""
    result = _run(pose_means.CONFIGURATION).triad("accelerometer")
    assert result is not None
    return result


def _run(text: str) -> Outcome:
    return run_stages(parse_config(Path("config.yaml"), text), RunContext())


def corrected_magnitude(result: TriadResult, readings: FloatArray) -> FloatArray:
    """|T K (v - b)|, (n,): eq. (1)-(2) of the paper with the stated parameters, by hand."""
    p = result.calibration.parameters
    ax, ay, az = p.misalignment_rad
    upper = np.array([[1, az, ay], [0, 1, ax], [0, 0, 1]])
    s = ((readings - p.bias_counts) / p.scale_counts_per_unit) @ upper.T
    return np.asarray(np.linalg.norm(s, axis=1))


@dataclass(frozen=True)
class LostFace:
    """A session without the poses near one face.

    ``said_good`` is what the program says of the directions, ``stated`` the worst sd that it
    states, ``error`` the rms error of the poses that were left out and ``size`` their number.
    """

    face: str
    said_good: bool
    stated: float
    error: float
    size: int


NEAR = 0.7
"""Cosine to the face from which a pose goes with it: 45°."""


def without_each_face(result: TriadResult) -> list[LostFace]:
    """The program's own poses less those of every face, and the calibration that is left."""
    poses, spec = result.calibration.fit.poses, result.calibration.spec
    model = result.calibration.fit.model
    corrected = result.calibration.fit.rows.vector
    unit = corrected / np.linalg.norm(corrected, axis=1, keepdims=True)
    lost = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            gone = sign * unit[:, axis] > NEAR
            face = f"{'+' if sign > 0 else '-'}{AXES[axis]} up"
            if not gone.any():
                continue
            try:
                calibration = calibrate_triad(fit(poses.take(~gone), model), spec)
            except Undetermined:
                lost.append(LostFace(face, False, np.nan, np.nan, int(gone.sum())))
                continue
            prediction = predict(calibration)
            assert prediction is not None
            at = poses.take(gone)
            error = np.linalg.norm(calibration.correct(at.conditions(at.reading)), axis=1)
            error -= at.reference.magnitude
            lost.append(LostFace(
                face, prediction.holds_everywhere and not prediction.unchecked,
                prediction.sd_worst, float(np.sqrt(np.mean(error**2))), int(gone.sum())))
    return lost


def prediction_words(prediction: Prediction) -> str:
    """Median, worst and where, mm/s²."""
    good = prediction.holds_everywhere and not prediction.unchecked
    return (f"{1e3 * prediction.sd_median:.2g}, {1e3 * prediction.sd_worst:.2g} at "
            f"{direction_name(prediction.worst_direction)}{'' if good else ', said'}")

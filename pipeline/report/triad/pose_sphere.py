"""The poses of a triad: the attitudes that they cover, their residuals, raw logs and pictures.

The position of a pose is the direction of the vertical in the axes of the sensor: the side that
faces up. The script of the page draws the sphere, so that it can be rotated.
"""

import base64
from collections.abc import Iterator

import numpy as np

from calib.diagnosis.next_measurement.advice import shown_name
from calib.fit.validation.leave_one_out import PoseResidual
from calib.numbers import NO_LENGTH, RPM
from calib.poses.attitudes import (
    NEAR_COSINE,
    WEDGE_DIRECTIONS,
    list_directions,
    natural_directions,
)
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.imu_log import AXES, TEMPERATURE, FloatArray, IntArray, Triad
from calib.poses.pose_set import PoseSet
from pipeline.exclusion import shortest_names
from pipeline.results.json_values import Json
from pipeline.stages.excluded_poses import ExcludedPose
from pipeline.stages.rate import SettingRate
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import DISPLAY, count, with_minus_signs, with_sd
from pipeline.text.names import command, word

LAID_WITHIN = float(np.cos(np.radians(10.0)))
"""The recording guide asks for the wedge poses to 10°; random directions are 17° off."""
MOST_REPEATS = 2.0
"""Multiple of the median number of poses in a direction: a design repeats all of them equally."""


def coverage_of(directions: FloatArray) -> tuple[list[tuple[FloatArray, bool]], str]:
    """The expected directions, each with whether one of the unit vectors (n, 3) is near, and a
    sentence; NaN for poses without a direction.

    None is expected where the poses do not follow the design: then no direction is missing.
    """
    known = directions[np.isfinite(directions).all(axis=1)]
    if not len(known):
        return [], ("These poses have no known direction: the plate was stopped and no "
                    "accelerometer was logged.")
    natural = natural_directions()
    near = natural @ known.T  # (26, n)
    covered = near.max(axis=1) >= NEAR_COSINE
    faces, corners = int(covered[:WEDGE_DIRECTIONS].sum()), int(covered[WEDGE_DIRECTIONS:].sum())
    if not _follows_design(near, faces):
        return [], (f"{count(len(known), 'pose')}. They do not follow the design of 6 "
                    f"faces and 12 edges, so no direction is marked as missing.")
    caption = (f"{count(len(known), 'pose')} cover {faces} of the 18 faces and edges and "
               f"{corners} of the 8 corners.")
    if faces < WEDGE_DIRECTIONS:
        missing = list_directions(natural[:WEDGE_DIRECTIONS][~covered[:WEDGE_DIRECTIONS]])
        caption += f" These directions are missing: {missing}."
    return list(zip(natural, map(bool, covered), strict=True)), caption


def _follows_design(near: FloatArray, faces: int) -> bool:
    """Whether the poses follow the 26 directions; ``near`` (26, n) are the cosines to them.

    Poses in a hand come near many of them too, some again and again: they are not a design with
    missing directions.
    """
    repeats = np.bincount(near.argmax(axis=0))
    repeats = repeats[repeats > 0]
    return bool(
        faces > WEDGE_DIRECTIONS / 2
        and np.median(near.max(axis=0)) >= LAID_WITHIN
        and repeats.max() <= MOST_REPEATS * np.median(repeats)
    )


LEVELS = 255  #: levels of a raw log's chart: one byte for every value
DIGITS = 4  #: digits of a direction


def sphere_json(outcome: Outcome, result: TriadResult) -> Json:
    """Directions, facts and raw logs of the poses of one triad.

    Parameters
    ----------
    outcome : Outcome
        The run, for the samples of its poses.
    result : TriadResult
        One of its triads.
    """
    up = up_directions(result)
    means = [mean for _, one in result.made_from.recorded.recorded for mean in one.means]
    along = reading_directions(result)
    expected, caption = coverage_of(up)
    return {
        "up": [_direction(one) for one in up],
        "expected": [
            {"up": [round(float(v), DIGITS) for v in direction], "covered": bool(is_covered)}
            for direction, is_covered in expected
        ],
        "caption": caption,
        "runs": list(result.calibration.fit.poses.run),
        "facts": [list(_facts(result.calibration.fit.poses, mean, i))
                  for i, mean in enumerate(means)],
        "traces": [None if mean.stated else _trace(result, mean, along[i])
                   for i, mean in enumerate(means)],
        "excluded": [_excluded(result, one) for one in result.excluded],
        "exclude": [command("exclude", outcome.config.source.path), *(
            word(f"{result.triad}.{name}")
            for name in shortest_names(result.calibration.fit.poses.label))],
        "frames": pose_frames(outcome, result),
    }


def _excluded(result: TriadResult, pose: ExcludedPose) -> Json:
    """An excluded pose on the sphere: its direction, and its prediction by the fit without it."""
    known = {"label": pose.label, "shown": shown_name(pose.label), "run": pose.run}
    if pose.predicted is None:
        return {**known, "up": None, "in_sd": None}
    up = _upward(result.triad, pose.predicted.vector[None], pose.predicted.poses)[0]
    return {**known, "in_sd": pose.predicted.residual.in_sd, "up": _direction(up)}


def up_directions(result: TriadResult) -> FloatArray:
    """The vertical in the axes of the sensor for every pose, unit vectors (n, 3).

    On the turning plate it is the axis of the measured rate; of a pose with the plate stopped only
    the specific force shows it: NaN where that was not logged.
    """
    fit = result.calibration.fit
    return _upward(result.triad, fit.rows.vector, fit.poses)


def _direction(up: FloatArray) -> list[float] | None:
    return [round(float(v), DIGITS) for v in up] if np.isfinite(up).all() else None


def _upward(triad: Triad, vector: FloatArray, poses: PoseSet) -> FloatArray:
    """The vertical by corrected vectors (n, 3) of n poses."""
    if triad == "gyroscope":
        turns = np.sign(poses.spin_rad_s)[:, None]
        vector = np.where(turns != 0, vector * turns, poses.force)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(vector / np.linalg.norm(vector, axis=1, keepdims=True))


def _facts(poses: PoseSet, mean: PoseMean, i: int) -> Iterator[tuple[str, str]]:
    """Names and values of the facts on a pose besides its residual."""
    if np.isfinite(poses.time_s[i]):
        yield "time", f"{poses.time_s[i] / 60:.1f} min"
    if not mean.stated:
        yield "length", f"{mean.duration_s:.1f} s"
    if poses.spin_rad_s[i]:
        yield "rate of the plate", with_minus_signs(f"{poses.spin_rad_s[i] / RPM:.3f} rpm")
    for name, values in poses.columns.items():
        unit = " °C" if name == TEMPERATURE else ""
        yield ("temperature" if unit else name), with_minus_signs(f"{values[i]:.4g}{unit}")


def reading_directions(result: TriadResult) -> FloatArray:
    """Change of the nominal readings (n, 3) while the corrected length grows by one, no unit.

    A pose whose length errs by r would have read its mean less r times that. In a pose whose waves
    count the residual says nothing of the mean: 0.
    """
    vector = result.calibration.fit.rows.vector
    matrix, _ = result.calibration.correction.linear_form()
    unit = vector / np.maximum(np.linalg.norm(vector, axis=1, keepdims=True), NO_LENGTH)
    fit = result.calibration.fit
    of_mean = fit.poses.reference.is_null | (fit.equations.row_count == 1)
    return np.asarray(np.linalg.solve(matrix, unit.T).T * of_mean[:, None])


def _trace(result: TriadResult, mean: PoseMean, along: FloatArray) -> Json:
    """The envelope of a raw log about its mean, in the triad's shown unit, and the model's place.

    A model that leaves the residual r predicts the mean at ``-r`` times ``along``, and 99.7 % of
    the samples within three times ``sd`` of it.

    ``values`` holds, for x, y, z in turn, the lowest of every stretch and then the highest, as
    bytes (base64) from ``low`` to ``high`` of that axis.
    """
    factor = DISPLAY[result.triad][1]
    one = mean.of(result.triad)
    about = (one.envelope - one.mean) * factor  # (e, 2, 3)
    low, high = about.min(axis=(0, 1)), about.max(axis=(0, 1))
    step = np.where(high > low, high - low, 1.0) / LEVELS
    levels = np.rint((about - low) / step).astype(np.uint8).transpose(2, 1, 0)
    return {
        "seconds": round(mean.duration_s, 2),
        "low": [float(f"{v:.4g}") for v in low],
        "high": [float(f"{v:.4g}") for v in high],
        "axes": list(AXES),
        "along": [float(f"{v:.4g}") for v in along],
        "sd": [float(f"{v:.4g}") for v in np.sqrt(one.scatter) * factor],
        "values": base64.b64encode(levels.tobytes()).decode("ascii"),
    }


def pose_rows(result: TriadResult) -> list[tuple[str, str, str, str]]:
    """Label, run, residual ± sd and residual in sds of every pose, for the table of all poses.

    With the plate stopped, or waves that count, the residual is a length.
    """
    return [_row(pose, result.triad) for pose in result.comparison.poses]


def excluded_rows(result: TriadResult) -> list[tuple[str, str, str, str]]:
    """Every excluded pose by the fit without it; without numbers where it is not a pose."""
    return [_row(one.predicted.residual, result.triad) if one.predicted is not None
            else (shown_name(one.label), one.run, "no pose of its run", "–")
            for one in result.excluded]


def _row(pose: PoseResidual, triad: Triad) -> tuple[str, str, str, str]:
    factor = DISPLAY[triad][1]
    return (shown_name(pose.label), pose.run,
            with_minus_signs(with_sd(pose.residual * factor, pose.sd * factor)),
            with_minus_signs(f"{pose.in_sd:.1f}"))


def pose_frames(outcome: Outcome, result: TriadResult) -> list[Json | None]:
    """For every pose of the fit its plate setting, and a small picture where its clip is its own.

    None where no clip was filmed. A clip of a whole run has no clock in common with the logs: its
    frame, which the page shows with the plate rates, is one of that run.
    """
    return [frame for setting, one in result.made_from.recorded.recorded
            for frame in _of_run(outcome.rates.get(setting), setting, one.places)]


def _of_run(rate: SettingRate | None, setting: str, places: IntArray) -> Iterator[Json | None]:
    for place in map(int, places):
        if rate is None or not rate.annotated:
            yield None
        elif len(rate.annotated) == 1:
            yield {"rate": setting}
        else:
            from vision.drawing import thumbnail  # OpenCV, which other pages do not need

            picture = base64.b64encode(thumbnail(rate.annotated[place])).decode()
            yield {"rate": setting, "clip": rate.sources[place],
                   "src": f"data:image/jpeg;base64,{picture}"}

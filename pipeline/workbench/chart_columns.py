"""Axes and colours of the residuals' chart."""

from collections.abc import Iterator, Mapping

import numpy as np
from scipy.special import betaincinv, ndtri

from calib.fit.triad.calibration import TriadCalibration
from calib.numbers import NO_LENGTH, RPM
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import AXES, TRIADS, FloatArray, ImuLog, Triad
from calib.poses.pose_set import PoseSet
from calib.poses.samples.in_step import plate_angle
from pipeline.config.sensor import sensor_specs
from pipeline.results.json_values import Json
from pipeline.text.formatting import DISPLAY
from pipeline.workbench.live_refits import OpenSession

BAND = (0.025, 0.975)  #: band of an ordered residual. Definition: 95 %
READING = {**DISPLAY, "accelerometer": ("m/s²", 1.0)}  #: units of readings; layout
PARTS = 12  #: parts of a turn; layout: waves once and twice per turn show


def chart_columns(session: OpenSession, triad: Triad) -> Json:
    """Quantities for the axes of a chart of the residuals.

    Returns
    -------
    dict
        ``columns``: of every pose, by their titles. ``phase``: the angles of the plate in the
        middle of ``PARTS`` parts of a turn, and by how much each part's residual differs from that
        of its pose, in the shown unit; empty lists where the pose shows no phase. ``quantiles``:
        normal quantiles of the poses with one row, with a band that holds each residual at 95 %.
    """
    calibration = session.refitted(session.as_run(), triad).calibration
    poses = calibration.fit.poses
    n = int((calibration.fit.equations.row_count == 1).sum())
    place = np.arange(1, n + 1)
    z, low, high = (ndtri(betaincinv(place, n + 1 - place, share)).tolist()
                    for share in (0.5, *BAND))
    return {
        "columns": {name: values.tolist() for name, values in _columns(poses)
                    if np.isfinite(values).all() and np.ptp(values) > 0},
        "phase": {"angle_deg": (np.arange(PARTS) * 360 / PARTS + 180 / PARTS).tolist(),
                  "beside": _beside(session, triad, calibration)},
        "quantiles": {"z": z, "low": low, "high": high},
    }


def _columns(poses: PoseSet) -> Iterator[tuple[str, FloatArray]]:
    """Title and value in every pose of its known quantities."""
    unit, factor = READING[poses.triad]
    yield "order of the poses", np.arange(1.0, len(poses) + 1)
    yield "time [min]", poses.time_s / 60
    yield "rate of the plate [rpm]", poses.spin_rad_s / RPM
    for k, axis in enumerate(AXES):
        yield f"reading {axis} [{unit}]", poses.reading[:, k] * factor
        yield f"specific force {axis} [m/s²]", poses.force[:, k]
    if poses.other_reading is not None:
        other = next(each for each in TRIADS if each != poses.triad)
        shown, per_si = READING[other]
        for k, axis in enumerate(AXES):
            yield f"{other} {axis} [{shown}]", poses.other_reading[:, k] * per_si
    if poses.run_time_s is not None:
        run = np.array(poses.run)
        begun = np.array([poses.run_time_s[run == name].min() for name in poses.run])
        yield "time since the run began [min]", (poses.run_time_s - begun) / 60
    yield from poses.columns.items()


def _beside(
    session: OpenSession, triad: Triad, calibration: TriadCalibration
) -> list[list[float]]:
    """The residual in each part of a turn, relative to that of the pose, for every pose."""
    poses, specs = calibration.fit.poses, sensor_specs(session.config.sensor)
    logs = {log.label: log for rate in dict.fromkeys(poses.run)
            for log in session.turning_logs(triad, rate)}
    vector = calibration.fit.rows.vector
    unit = vector / np.maximum(np.linalg.norm(vector, axis=1, keepdims=True), NO_LENGTH)
    gain = unit @ calibration.correction.linear_form()[0]  # of the length, by the reading
    factor = DISPLAY[triad][1]
    return [(_by_phase(logs[label], triad, specs, session.rates[run].rate_rad_s) @ gain[i] * factor
             ).tolist() if label in logs else []
            for i, (label, run) in enumerate(zip(poses.label, poses.run, strict=True))]


def _by_phase(
    log: ImuLog, triad: Triad, specs: Mapping[str, TriadSpec], rate_rad_s: float
) -> FloatArray:
    """Mean reading in each part of a turn less that of the pose, (p, 3), nominal SI.

    The phase counts from the beginning of the pose, in the direction in which the plate turns.
    """
    reading = specs[triad].nominal(log.readings(triad))
    gyroscope = None
    if log.has("gyroscope") and "gyroscope" in specs:
        gyroscope = specs["gyroscope"].nominal(log.readings("gyroscope"))
    angle = plate_angle(log.time_s, gyroscope, rate_rad_s)
    part = (angle / (2 * np.pi) * PARTS).astype(int) % PARTS
    count = np.maximum(np.bincount(part, minlength=PARTS), 1)
    mean = np.stack([np.bincount(part, column, PARTS) / count for column in reading.T], axis=1)
    return np.asarray(mean - reading.mean(axis=0))

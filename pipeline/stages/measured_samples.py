"""The log of one pose without what is no measurement."""

from calib.poses.checks.frozen import without_frozen
from calib.poses.checks.pose_checks import check_counts, check_range
from calib.poses.checks.stray_samples import without_strays
from calib.poses.data_sheet import Specs
from calib.poses.imu_log import TRIADS, ImuLog


def measured_samples(log: ImuLog, turning: bool, specs: Specs) -> tuple[ImuLog, str | None]:
    """The samples of a pose that the sensor measured, and a note on those that are left out.

    Raises
    ------
    UnusableLog
        A value that the converter cannot give: the file is damaged, or of another sensor.
    Undetermined
        An axis is saturated, or too many samples are no measurement.
    """
    for triad in TRIADS:
        spec = specs.get(triad)
        if spec is not None and log.has(triad):
            counts = spec.signed(log.readings(triad))
            check_range(log.label, triad, counts, spec)
            low, high = spec.count_range
            # At an end on all axes at once a reading failed; on one axis it is saturated.
            failed = ((counts <= low) | (counts >= high)).all(axis=1)
            check_counts(log.label, triad, counts[~failed], spec)
    running, frozen = without_frozen(log, turning)
    measured, strays = without_strays(running)
    return measured, " ".join(filter(None, [frozen, strays])) or None

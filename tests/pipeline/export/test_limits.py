"""A log that is corrected, against what the calibration is valid for."""

from dataclasses import replace

import numpy as np
import pytest

from calib.errors import UnusableLog
from pipeline.export.apply import apply_results
from pipeline.export.limits import compare_with_gravity, warnings_of
from pipeline.results.read import load_results
from tests.pipeline.conftest import RunSession
from tests.pipeline.export.stored_results import a_log


def test_only_a_rest_is_compared_with_gravity(finished: RunSession) -> None:
    """Mean readings, one of each attitude, are no rest; samples of one attitude are."""
    stored, counts = load_results(finished.folder), a_log()
    direction = np.random.default_rng(1).normal(size=(500, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]

    def compared(force: np.ndarray) -> tuple[str, ...]:
        applied = replace(apply_results(stored, counts), triads={"accelerometer": force})
        return compare_with_gravity(stored, counts, applied)

    assert "no part of the log shows the sensor at rest" in compared(9.8 * direction)[0]
    assert compared(9.8 * direction[:1].repeat(500, axis=0) + 0.1 * direction) == ()
    # Attitudes at either end, and moving between: a quarter of the log decides.
    stops = direction[:2].repeat(250, axis=0)
    stops[50:400] = direction[50:400]
    assert compared(9.8 * stops) == ()
    with pytest.raises(UnusableLog, match=r"at rest the corrected specific force is 4\.9"):
        compared(4.9 * stops)
    with pytest.raises(UnusableLog, match="at rest"):  # gravity taken out already
        compared(0.1 * direction)


def test_every_sample_outside_the_range_of_the_poses_is_counted(finished: RunSession) -> None:
    """Also those within the margin that by itself is worth no warning."""
    stored, log = load_results(finished.folder), a_log()
    seen = [pose.columns["temperature_c"] for each in stored.contents.triads.values()
            for pose in each.poses]
    warmth = np.full(len(log.time_s), max(seen) + 0.01 * np.ptp(seen))
    columns = {**log.columns, "temperature_c": warmth}
    assert not [*warnings_of(stored, replace(log, columns=columns), False)]
    warmth[0] += np.ptp(seen)
    warning, = warnings_of(stored, replace(log, columns=columns), False)
    assert f"{len(warmth)} of {len(warmth)} samples are outside" in warning

"""What a gyroscope at rest reads, by the largest cluster of the means of stops; few levels."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import UnreadableInput
from pipeline.guess.agreement import disagreements
from pipeline.guess.files import guess_files
from pipeline.guess.pool import common_mean
from pipeline.guess.session import guess_session
from tests.pipeline.guess.evening import Evening
from tests.pipeline.guess.hand_log import hand_log

BIAS, PLATE = np.array([0.03, -0.04, 0.06]), np.array([0.0, 0.1, 3.5])


def test_poses_of_one_attitude_on_the_plate_are_no_rest() -> None:
    np.testing.assert_allclose(common_mean(np.array([BIAS + PLATE] * 8 + [BIAS] * 8)), BIAS)


def test_rests_alike_are_nearer_than_a_tenth_of_what_both_directions_differ_by() -> None:
    """The plate turns both ways: half of what they differ by is the rate."""
    rests = np.linspace(-0.15, 0.15, 9)[:, None] * PLATE
    turns = np.array([PLATE, -PLATE] * 8)
    np.testing.assert_allclose(common_mean(np.concatenate([turns, BIAS + rests])), BIAS)


def test_few_stops_alike_have_no_common_mean() -> None:
    apart = np.arange(5)[:, None] * PLATE
    assert common_mean(np.concatenate([apart, [BIAS + PLATE] * 4])) is None


def test_a_night_at_rest_takes_memory_in_proportion_to_its_length() -> None:
    """Distances of all pairs of 5,000 stops are 600 MB."""
    means = BIAS + np.random.default_rng(0).normal(0, 0.1 * abs(BIAS).max(), (5_000, 3))
    tracemalloc.start()
    try:
        mean = common_mean(means)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 20 * means.nbytes
    np.testing.assert_allclose(mean, BIAS, atol=0.002)


@pytest.mark.parametrize("range_g", [32.0, 256.0, 512.0])
@pytest.mark.parametrize("header", [Evening.header, "t,k,l,m,n,o,p,q"])
def test_poses_of_few_levels_are_all_kept(tmp_path: Path, range_g: float, header: str) -> None:
    """Converters of 8 to 12 bits with noise below one count: alone, a pose looks like anything."""
    evening = Evening(range_g=range_g, range_deg_s=4e3, seconds=3.0, header=header)
    guess = guess_session(guess_files(evening.write(tmp_path, "rest", 0.0, 1), None)[0])
    (source,) = guess.sources
    assert (source.layout, len(source.tables)) == ("files", 18)
    for table in source.tables:
        assert table.accelerometer is not None
        assert table.accelerometer.unit == f"counts, {32768 / range_g:g} per g, twos-complement"


def test_a_field_in_whole_microtesla_is_no_accelerometer_of_few_levels(tmp_path: Path) -> None:
    field = hand_log().field * 62
    np.savetxt(tmp_path / "a.csv", np.column_stack([np.arange(len(field)) / 100, np.rint(field)]),
               "%g", ",", header="t,x,y,z", comments="")
    with pytest.raises(UnreadableInput, match="gravity's length at rest in a usual unit"):
        guess_files([tmp_path / "a.csv"], None)


def test_poses_of_few_levels_that_show_no_sensor_together_are_none_alone(tmp_path: Path) -> None:
    """90 counts per g are no range: five poses alone would look like one of 64 counts per g."""
    evening = Evening(range_g=32768 / 90, range_deg_s=2e3, seconds=3.0, header="t,k,l,m,n,o,p,q")
    with pytest.raises(UnreadableInput, match="no accelerometer and no gyroscope"):
        guess_session(guess_files(evening.write(tmp_path, "rest", 0.0, 1), None)[0])


def test_axes_that_read_alike_in_one_pose_are_not_written_twice(tmp_path: Path) -> None:
    files = Evening(seconds=3.0).write(tmp_path, "rest", 0.0, 1)
    head, *rows = files[8].read_text("utf-8").split()
    files[8].write_text("\n".join([head, *(f"{row.split(',')[0]},5678,40,5678,0,20,-13,8"
                                           for row in rows)]), "utf-8")
    guess = guess_session(guess_files(files, None)[0])
    assert not any("hold the same numbers" in fault for fault in disagreements(guess))

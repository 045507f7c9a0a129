"""Angles that are not the plate's are told by its inertia, and the plate's are carried on."""

import numpy as np

from vision.plate.inertia import carried_on, turns_on

FRAMES = 120
STEP = 0.14  # rad per frame


def test_frames_whose_angle_stands_or_is_noise_do_not_turn_on() -> None:
    rng = np.random.default_rng(4)
    rough = STEP * np.arange(FRAMES) * 1.001  # drifts away by a degree
    true = STEP * np.arange(FRAMES) + 0.3
    out = np.cos(true) < 0
    for elsewhere in (np.full(FRAMES, 2.0), rng.uniform(-np.pi, np.pi, FRAMES)):
        shown = np.where(out, elsewhere, true + rng.normal(0, 0.004, FRAMES))
        angle = rough + np.angle(np.exp(1j * (shown - rough)))
        goes = turns_on(angle, rough)
        assert goes[~out].all()
        assert goes[out].mean() < 0.4  # by chance, and next to the plate's own angle
        beyond = np.angle(np.exp(1j * (carried_on(angle, rough, goes & ~out) - true)))
        assert np.abs(beyond).max() < 0.02


def test_a_plate_that_is_seen_all_the_time_turns_on_in_every_frame() -> None:
    rng = np.random.default_rng(5)
    rough = STEP * np.arange(FRAMES)
    angle = rough + rng.normal(0, 0.003, FRAMES)
    assert turns_on(angle, rough).all()
    assert np.array_equal(carried_on(angle, rough, np.ones(FRAMES, bool)), angle)


def test_a_dropped_frame_leaves_no_frame_out() -> None:
    rough = STEP * np.arange(FRAMES)
    angle = rough + STEP * (np.arange(FRAMES) > 60)  # a frame was dropped there
    assert turns_on(angle, rough).all()  # each turns on from before, or to after


def test_a_plate_at_rest_before_it_turns_is_seen_all_the_time() -> None:
    rng = np.random.default_rng(6)
    true = STEP * np.maximum(np.arange(FRAMES) - 30, 0)
    assert turns_on(true + rng.normal(0, 0.003, FRAMES), true).all()

"""Which of two outlines is the plate, and what is believed to be one."""

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from vision.geometry import view_of_ellipse
from vision.plate.choice import PlateCandidate, seek_spindle
from vision.plate.evidence import believed
from vision.plate.learning_frames import LearningFrames
from vision.plate.rotation import CoarseRotation
from vision.plate.template import Alignment


def candidate(explained: float, varying: float = 1.0, frames: int = 100) -> PlateCandidate:
    template = SimpleNamespace(explained=explained, varying=varying)
    coarse = SimpleNamespace(template=template, used=np.ones(frames, bool))
    return PlateCandidate(cast(Alignment, coarse), 0.9)


def test_of_two_outlines_of_one_rim_the_better_explained_is_the_plate() -> None:
    rim = candidate(0.96)
    assert candidate(0.99, varying=0.95).clarity > rim.clarity
    assert candidate(0.93, varying=1.05).clarity < rim.clarity


def test_a_label_is_not_the_plate_and_a_stand_around_it_is_no_part_of_it() -> None:
    record = candidate(0.8, varying=2.0)
    assert candidate(0.95, varying=0.5).clarity < record.clarity
    with_stand = candidate(0.5, varying=3.3)
    assert with_stand.clarity < record.clarity


def test_what_noise_explains_of_itself_is_not_believed() -> None:
    rng = np.random.default_rng(0)
    for frames in (28, 100):
        noise = rng.normal(size=(frames, 400))
        of_one_mean = float((frames * noise.mean(axis=0) ** 2).sum() / (noise**2).sum())
        assert 0.7 < of_one_mean * (frames - 1) / (1 - of_one_mean) < 1.4
        assert not believed(of_one_mean, frames)
        assert not candidate(of_one_mean, frames=frames).is_believed


def test_a_plate_is_believed_though_most_of_what_varies_is_noise() -> None:
    """Frames of a dark film."""
    assert candidate(0.25).is_believed
    assert not candidate(0.25).is_certain


@pytest.mark.parametrize(("shown", "searched"), [(0.05, False), (0.4, True), (0.9, False)])
def test_a_spindle_is_searched_where_something_turns_and_not_in_noise(
    shown: float, searched: bool
) -> None:
    coherence = iter([shown, *[shown + 0.01] * 20])
    frames = SimpleNamespace(rotation=lambda view: CoarseRotation(
        np.zeros(60), next(coherence), slice(0, 48)))
    rim = view_of_ellipse((50.0, 50.0), (40.0, 20.0), 0.0)
    assert (seek_spindle(rim, cast(LearningFrames, frames))[0] is not rim) == searched

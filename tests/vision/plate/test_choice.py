"""Which of two outlines is the plate, and what is believed to be one."""

from types import SimpleNamespace
from typing import cast

import numpy as np

from vision.plate.choice import PlateCandidate
from vision.plate.evidence import believed
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

"""Which of two outlines is the plate."""

from types import SimpleNamespace
from typing import cast

from vision.geometry import view_of_ellipse
from vision.plate.choice import PlateCandidate
from vision.plate.template import Alignment


def candidate(
    radius_px: float, *, explained: float = 0.99, coherence: float = 0.6, turning: float = 1.0,
    x_px: float = 100.0,
) -> PlateCandidate:
    view = view_of_ellipse((x_px, 100.0), (radius_px, radius_px), 0.0)
    template = SimpleNamespace(grid=SimpleNamespace(view=view), explained=explained)
    return PlateCandidate(cast(Alignment, SimpleNamespace(template=template)), coherence, turning)


def test_of_two_outlines_of_one_rim_the_better_explained_is_the_plate() -> None:
    rim = candidate(90, explained=0.99, coherence=0.64)
    assert candidate(85, explained=0.995, coherence=0.63).rather_than(rim)
    assert not candidate(85, explained=0.98, coherence=0.70).rather_than(rim)


def test_a_label_is_not_the_plate_though_it_turns_more_coherently() -> None:
    rim = candidate(90, turning=2.0)
    assert not candidate(30, coherence=0.9, turning=0.5).rather_than(rim)
    assert candidate(30, coherence=0.9, turning=1.9).rather_than(rim)  # a stand is around it


def test_of_plates_side_by_side_the_more_coherent_is_taken() -> None:
    other = candidate(90)
    assert candidate(85, x_px=300.0, explained=0.9, coherence=0.7).rather_than(other)
    assert not candidate(85, x_px=300.0, coherence=0.5).rather_than(other)

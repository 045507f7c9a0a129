"""The stages of a run, as a table: what each makes, and from what.

    config.yaml ─┬─ rates ─────────┬──────────────────────────┐
                 │                 ▼                          ▼
                 ├──────────── recordings ─┬─ accelerometer ─ gyroscope
                 │                         └────────│─────────▲
                 └──────────────────────────────────▼
                                              installation

A stage is a plain function ``(config, workplace, *needs)``. It returns its artefact, or None where
the configuration has no section for it. The order of the table is the order of the run.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pipeline.stages.mounting import measure_mounting
from pipeline.stages.plate_settings import measure_rates
from pipeline.stages.poses import average_recordings
from pipeline.stages.triads import calibrate_accelerometer, calibrate_gyroscope


@dataclass(frozen=True)
class Stage:
    """One stage: the name of the artefact it makes, the artefacts it needs, and its function."""

    name: str
    needs: tuple[str, ...]
    make: Callable[..., Any]


STAGES = (
    Stage("rates", (), measure_rates),
    Stage("recordings", ("rates",), average_recordings),
    Stage("accelerometer", ("recordings",), calibrate_accelerometer),
    Stage("gyroscope", ("rates", "recordings", "accelerometer"), calibrate_gyroscope),
    Stage("installation", ("accelerometer",), measure_mounting),
)

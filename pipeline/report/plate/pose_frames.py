"""The frame of the clip that belongs to a pose: of its own clip, or of the one of its run."""

import base64
from collections.abc import Iterator

from calib.poses.imu_log import IntArray
from pipeline.results.json_values import Json
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult


def pose_frames(outcome: Outcome, result: TriadResult) -> list[Json | None]:
    """For every pose of the fit its plate setting, and a small picture where its clip is its own.

    None where no clip was filmed. A clip of a whole run has no clock in common with the logs: its
    frame, which the page shows with the plate rates, is one of that run.
    """
    return [frame for run in outcome.config.runs_of(result.triad)
            for frame in _of_run(outcome, run.rate, outcome.recordings.of(run).places)]


def _of_run(outcome: Outcome, setting: str, places: IntArray) -> Iterator[Json | None]:
    rate = outcome.rates.get(setting)
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

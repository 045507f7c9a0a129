"""What each threshold of ``vision.rate`` does: halved and doubled, over simulated phase tracks.

    python -m tests.bench.rate_thresholds [--tracks 120] [--only rate.dropped_frames]

The tracks need no image: plates that turn evenly, wobble, drift, stop, run up; frames dropped,
repeated, mismeasured, noisy, left out, stamped late; labels that show little at one angle; cameras
that roll. Of each track it is known whether it can be measured, its rate, how many frames were
dropped and which term is missing. Printed for each constant, at half and at twice its value:
refusals without cause, rates that should have been refused, wrong counts of dropped frames, wrong
diagnoses, wrong warnings, errors beyond four sds, their rms in sds and the median sd in ppm. The
table stands in ``data/docs/thresholds.md``.
"""

import argparse
from dataclasses import dataclass

import numpy as np

from tests.bench.simulated_tracks import Case, cases
from tests.bench.threshold_records import with_factors
from tests.source_tree import begins
from tests.thresholds import thresholds
from vision.errors import RateRefused
from vision.rate.measure import measure_rate
from vision.rate.timebase import Timebase

CLOCK = Timebase(ppm=0.0)
FAR = 4.0  #: sds; an error beyond is counted


@dataclass(frozen=True)
class Score:
    """What went wrong over all tracks."""

    unjust: int  #: refused, and could be measured
    unrefused: int  #: not refused, and has no constant rate
    count: int  #: dropped frames miscounted
    diagnosis: int
    warning: int
    far: int  #: errors beyond ``FAR`` sds
    rms: float  #: of the errors, in sds
    ppm: float  #: median stated sd

    def __str__(self) -> str:
        return (f"{self.unjust:4d} {self.unrefused:4d} {self.count:4d} {self.diagnosis:4d} "
                f"{self.warning:4d} {self.far:4d} {self.rms:7.2f} {self.ppm:8.2f}")


def judge(every: list[Case], show: bool = False) -> Score:
    """Measure all tracks."""
    unjust = unrefused = count = diagnosis = warning = 0
    pulls, sds = [], []
    for i, case in enumerate(every):
        try:
            rate = measure_rate(case.track, timebase=CLOCK, **case.how)
        except RateRefused as refused:
            if case.rate_rad_s is not None:
                unjust += 1
                if show:
                    print(f"{i:4d} {case.kind}: refused: {str(refused)[:150]}")
            continue
        if case.rate_rad_s is None:
            unrefused += 1
            if show:
                print(f"{i:4d} {case.kind}: not refused")
            continue
        signed = rate.rate_rad_s * (1 if rate.direction == "ccw" else -1)
        pull = (signed - case.rate_rad_s) / rate.uncertainty.image_rad_s
        pulls.append(pull)
        sds.append(rate.uncertainty.image_rad_s / rate.rate_rad_s * 1e6)
        wrong = case.dropped is not None and rate.frames.dropped != case.dropped
        count += wrong
        verdict = rate.diagnosis.verdict
        named = (*rate.diagnosis.group, rate.diagnosis.name)
        odd = case.missing is not None and (
            verdict != "nothing_missing" if case.missing == "" else case.missing not in named
        )
        diagnosis += odd
        unsaid = case.warning is not None and (
            bool(rate.warnings)
            if case.warning == ""
            else not any(case.warning in text for text in rate.warnings)
        )
        warning += unsaid
        if show and (wrong or odd or unsaid or abs(pull) > FAR):
            print(f"{i:4d} {case.kind}: {pull:+.1f} sd, dropped {rate.frames.dropped} of "
                  f"{case.dropped}, {verdict} {rate.diagnosis.name} for {case.missing!r}, "
                  f"warnings {[text[9:70] for text in rate.warnings]} for {case.warning!r}")
    size = np.abs(pulls)
    return Score(unjust, unrefused, count, diagnosis, warning, int((size > FAR).sum()),
                 float(np.sqrt((size.clip(max=20) ** 2).mean())), float(np.median(sds)))


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tracks", type=int, default=120)
    parser.add_argument("--only", default="rate")
    options = parser.parse_args()
    every = list(cases(options.tracks))
    usual = str(judge(every, show=True))
    print(f"refused, not refused, count, diagnosis, warnings, beyond {FAR:g} sds, rms, sd in ppm")
    print(f"{'as they are':<50} {usual}", flush=True)
    for one in thresholds("vision.rate"):
        if not begins(one.path, options.only):
            continue
        scores = ["no effect" if score == usual else str(score)
                  for score in with_factors("vision", one, lambda: str(judge(every)))]
        print(f"{one.path:<40} {one.cells[1]:>7} {scores[0]:>48} {scores[1]:>48}", flush=True)


if __name__ == "__main__":
    main()

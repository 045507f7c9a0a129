"""A measured rate as text: one line for the setting, several for each clip, the verdict."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from calib.numbers import RPM
from pipeline.stages.rate import SettingRate
from pipeline.text.formatting import NAME_WIDTH, count, relative
from pipeline.text.names import command
from vision.phase_track import LUMA
from vision.rate.terms import ALWAYS

if TYPE_CHECKING:
    from vision.phase_track import RateHistory

MOST_ROWS = 20  #: lines of rate against time, less than a screen of 24
COMPLETE = "nothing_missing"  #: verdict on a clip whose rate model describes it


def rate_line(rate: SettingRate) -> str:
    """``rate slow       16.667 rpm ± 12 ppm, 16.6 turns, ccw``."""
    parts = [f"{rate.rate_rad_s / RPM:.4f} rpm ± {relative(rate.sd_rad_s / rate.rate_rad_s)}"]
    if rate.clips:
        parts.append(f"{sum(clip.revolutions for clip in rate.clips):.1f} turns")
        parts.append(str(rate.plate.direction))
        if len(rate.clips) > 1:
            parts.append(count(len(rate.clips), "clip"))
    else:
        parts.append("stated in the configuration")
    return f"{f'rate {rate.name}':<{NAME_WIDTH}} {', '.join(parts)}"


@dataclass(frozen=True)
class RateVerdict:
    """Terms that the rate model of one plate setting lacks, in its clip with the largest residual.

    ``lacks`` is the missing term, empty where the clip determines none; ``command`` adds it.
    ``in_the_rate`` is whether the rate is fitted with the term in any model; ``together`` is the
    reason why all clips of the session decide it, reported once.
    """

    setting: str
    complete: bool
    text: str
    lacks: str = ""
    command: str = ""
    rms_deg: float = 0.0
    in_the_rate: bool = True
    together: str = ""


def rate_verdict(rate: SettingRate, config: Path) -> RateVerdict:
    """The verdict on one plate setting, with the command that changes ``config``."""
    if not rate.clips:
        return RateVerdict(rate.name, True,
                           "The configuration states this rate; it was not measured from a clip.")
    clip = rate.clips[worst_clip(rate)]
    diagnosis = clip.diagnosis
    lacks = (diagnosis.name or "") if diagnosis.verdict == "effect" else ""
    in_the_rate = diagnosis.name in ALWAYS
    # Among terms that the clip cannot separate, one that changes no rate may be added.
    addable = lacks or (diagnosis.name if diagnosis.verdict == "ambiguous" and in_the_rate else "")
    return RateVerdict(
        rate.name, diagnosis.verdict == COMPLETE,
        " ".join(filter(None, (diagnosis.explanation, diagnosis.record_next))), lacks,
        command("add", config, f"rate.{rate.name}.{addable}") if addable else "",
        math.degrees(clip.fit.rms_rad), in_the_rate, diagnosis.together)


def worst_clip(rate: SettingRate) -> int:
    """Number of the clip with the largest residual."""
    return max(range(len(rate.clips)), key=lambda i: rate.clips[i].fit.rms_rad)


def verdict_lines(rates: Iterable[SettingRate]) -> Iterator[str]:
    """Terms that the rate models lack, and why all clips decide so; nothing without any."""
    lacking = [verdict for rate in rates
               if not (verdict := rate_verdict(rate, Path("CONFIG"))).complete]
    for verdict in lacking:
        yield f"rate.{verdict.setting}: {verdict.text}"
    yield from reasons_of(lacking)


def reasons_of(verdicts: Iterable[RateVerdict]) -> tuple[str, ...]:
    """Reasons of decisions that all clips of the session make, each once."""
    return tuple(dict.fromkeys(verdict.together for verdict in verdicts if verdict.together))


def clip_lines(rate: SettingRate) -> Iterator[str]:
    """For each clip: the rate by counting frames, its difference, and the diagnosis."""
    for clip in rate.clips:
        if clip.channel != LUMA:
            yield f"  tracked by colour, {clip.channel}: the brightness shows no rotation"
        counted = clip.cross_checks.frame_count
        if counted is not None:
            difference = counted.rate_rad_s / clip.rate_rad_s - 1
            yield (
                f"  by counting frames {counted.rate_rad_s / RPM:.4f} rpm "
                f"± {relative(counted.sd_rad_s / counted.rate_rad_s)}, "
                f"difference {difference * 1e6:+.0f} ppm"
            )
        if len(clip.aliases.rates_rad_s) > 1:
            others = ", ".join(
                f"{abs(other) / RPM:.4g} {'ccw' if other > 0 else 'cw'}"
                for other in clip.aliases.rates_rad_s[1:]
            )
            yield f"  these rates give the same frames: {others} rpm; {clip.aliases.reason}"
        yield f"  {clip.diagnosis.explanation}"


def rate_history_lines(name: str, history: "RateHistory") -> Iterator[str]:
    """Rate against time of a plate whose rate is not constant, at most ``MOST_ROWS`` rows."""
    head = f"{f'rate {name}':<{NAME_WIDTH}}"
    yield f"{head} not constant; time [s], mean rate over one revolution [rpm]:"
    count = len(history.time_s)
    for i in np.linspace(0, count - 1, min(count, MOST_ROWS)).round().astype(int):
        yield f"  {history.time_s[i]:8.2f}  {history.rate_rad_s[i] / RPM:+9.3f}"

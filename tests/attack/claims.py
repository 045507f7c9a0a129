"""What the program says is wrong with a session: each of its sentences as one claim.

A claim is a cause that the user is sent after. A verdict that leaves the cause open (noise, odds
between several, a shape that nothing listed has) claims nothing. Poses that a claim names count:
the right cause in another pose is a wrong claim.
"""

import re
from collections.abc import Collection
from dataclasses import dataclass, field

from tests.attack.judged import Judged

#: Claim -> narrow pattern of the sentence that makes it; the first that matches counts.
SENTENCES = {
    "failed reading": r"are no measurement",
    "frozen": r": froze: |: stands still: |frozen blocks?, in which| stands still at ",
    "clipped": r"is saturated: |the axis is clipped there",
    "moved": r": the sensor moved: |: the sensor was moved on|: the sensor was shaken",
    "unsteady": r"the plate (sped up|slowed down) during|the plate did not turn steadily",
    "missing samples": r"lack samples for a quarter of a turn of the plate",
    "time stamps": r"time does not increase|clock makes no sense|do not count seconds|"
                   r": its time stamps are .* samples in a turn|s by its time stamps, less than "
                   r"one turn|count time in different units|its newest row is first",
    "copied": r" is in gyroscope\.runs|digit by digit|hold the same \w+ samples|"
              r"samples are used twice|to the last digit",
    "dead axis": r": \w+ [xyz] is dead: ",
    "other zero": r"do not read as at rest",
    "two triads": r"are not readings of one pose",
    "axes": r"exchanged in|exchanged\. Name|undone: .*(opposite sign|are exchanged|is logged as)|"
            r"its axes are exchanged or mirrored|no rotation joins their directions|"
            r"triads point along its axis, but here only if|unlike in the other runs\. Name|"
            r"It fits if .*(opposite sign|are exchanged|is logged as)",
    "range": r"undone: the readings are|It fits if the readings are",
    "gains of runs": r"but their gains differ by",
    "another sensor": r"are of another sensor, range, unit|those of another unit, another range or",
    "rate": r"are exchanged \(chi|the plate turned at .* rpm in run|look like poses at|"
            r"Either the rate belongs to another run|rate_rad_s: |a rate that scatters|determines "
            r"no scale|the rates of its runs scatter|plate whose rate scatters is|'rate_scatter'",
    "not turning, or data sheet": r"Either the plate was not turning in these poses, or the stated",
    "data sheet": r"times the data sheet's|counts run from .* but \d+ bit|"
                  r"by the data sheet the \w+ reads|bits: found",
    "gravity": r"site\.gravity_m_s2: ",
    "sds": r"times too large: chi²/dof is",
    "short poses": r"poses of [\d.]+ s are short: ",
    "bad pose": r"^bad_pose |contradict those of all other poses, and by no exchange",
}
#: Verdicts and remarks that name no cause.
OPEN = (r"^ambiguous |^unknown |^noise |^refused |^effect .*'(extra_noise|pose_scatter)' |"
        r"the accelerometer's model determines the specific force to|more poses have a warning of")
EFFECT = re.compile(r"'([a-z_:]+)'(?= is missing| and '| are missing|, ')")
POSE = re.compile(r"(?:accelerometer|gyroscope/\w+)/pose_\d+\.csv")


@dataclass(frozen=True)
class Claims:
    """Everything that was claimed.

    Attributes
    ----------
    causes : tuple of str
        Keys of ``SENTENCES``, names of effects, or the beginning of a sentence that is neither.
    poses : frozenset of str
        The files that a claim names.
    """

    causes: tuple[str, ...]
    poses: frozenset[str] = field(default_factory=frozenset)

    def are_right(self, causes: Collection[str], poses: Collection[str]) -> bool:
        """Whether every cause is one of ``causes``, and every pose one of ``poses``."""
        return set(self.causes) <= set(causes) and self.poses <= set(poses)


def claims_of(judged: Judged) -> Claims:
    """What a run claims, without its remarks."""
    causes: dict[str, None] = {}
    poses: set[str] = set()
    for sentence in _sentences(judged):
        if re.search(OPEN, sentence):
            continue
        causes |= dict.fromkeys(_causes(sentence))
        poses |= {*POSE.findall(sentence)}
    return Claims(tuple(causes), frozenset(poses))


def _sentences(judged: Judged) -> list[str]:
    verdicts = [f"{code} {judged.texts[triad]}" for triad, code in judged.verdicts.items()
                if code != "nothing_missing"]
    return [*filter(None, [judged.refusal]), *judged.warnings, *verdicts]


def _causes(sentence: str) -> list[str]:
    if sentence.startswith("effect "):
        return EFFECT.findall(sentence.split(". ")[0])
    for cause, pattern in SENTENCES.items():
        if re.search(pattern, sentence, re.IGNORECASE):
            return [cause]
    return [sentence[:60]]

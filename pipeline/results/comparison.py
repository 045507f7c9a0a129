"""Several stored calibrations of one sensor side by side: parameters, errors, each on all poses.

    error of A on the poses of B = rms of |A(reading of B)| - reference of B

What a calibration errs by on the poses of another session is what it will err by in use; its own
residual is smaller, because it was fitted to it.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from scipy.special import ndtri

from calib.effects.catalogue import UnknownEffect, find_effect
from calib.poses.imu_log import AXES
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.results.json_values import number, unit_of
from pipeline.results.names import PARAMETERS
from pipeline.results.poses import StoredPoses, rms
from pipeline.results.read import Stored, StoredTriad

CHANCE = 0.01
"""A choice: probability that a change is stated of a sensor that has not changed."""


@dataclass(frozen=True)
class ComparedParameter:
    """One parameter of all calibrations; None where one does not have it.

    ``apart_sd`` is its distance from the first calibration in sds of the difference, None where
    one of the two was not fitted. What only one of them cannot see is in that sd, at the size
    typical of the sensor. ``is_effect`` is whether it is none of the nine parameters.
    """

    name: str
    unit: str
    is_effect: bool
    values: tuple[float | None, ...]
    sds: tuple[float | None, ...]
    apart_sd: tuple[float | None, ...]


@dataclass(frozen=True)
class ComparedTriad:
    """One triad of all calibrations, in the order of the results; None where one has no such.

    Attributes
    ----------
    triad : str
    sections : tuple of mapping or None
        Its section of each results.json.
    parameters : tuple of ComparedParameter
    error_on_poses : tuple of tuple of float or None
        ``error_on_poses[b][a]`` is what calibration a errs by on the poses of b, rms, SI; None
        where one of its effects needs what the results of b do not hold.
    same_poses, same_sheet : tuple of bool
        Which results are of the same poses as the first, and which have its data sheet: only then
        are counts of the one counts of the other.
    """

    triad: str
    sections: tuple[Mapping[str, Any] | None, ...]
    parameters: tuple[ComparedParameter, ...]
    error_on_poses: tuple[tuple[float | None, ...], ...]
    same_poses: tuple[bool, ...]
    same_sheet: tuple[bool, ...]

    def farthest(self, k: int) -> ComparedParameter | None:
        """The parameter of calibration k that is the most sds from that of the first."""
        known = [parameter for parameter in self.parameters if parameter.apart_sd[k] is not None]
        return max(known, key=lambda one: abs(one.apart_sd[k] or 0.0), default=None)

    def chance_limit_sd(self, k: int) -> float:
        """Sds that the farthest of so many parameters exceeds by chance alone in one of a hundred
        cases (Šidák, *Rectangular Confidence Regions for the Means of Multivariate Normal
        Distributions*, 1967).
        """
        count = sum(parameter.apart_sd[k] is not None for parameter in self.parameters)
        return float(-ndtri((1 - (1 - CHANCE) ** (1 / max(count, 1))) / 2))


def compare_calibrations(results: Sequence[Stored]) -> tuple[ComparedTriad, ...]:
    """Every triad that two of the ``results`` have.

    Parameters
    ----------
    results : sequence of Stored
        Two or more results.json of one sensor.
    """
    compared = []
    for triad in TRIAD_KINDS:
        triads = [next((t for t in stored.triads if t.name == triad), None) for stored in results]
        if sum(one is not None for one in triads) >= 2:
            sections = tuple(stored.contents.get(triad) for stored in results)
            compared.append(ComparedTriad(
                triad, sections, tuple(_parameters(triad, triads, sections)),
                tuple(_errors_on(section, one, triads)
                      for section, one in zip(sections, triads, strict=True)),
                tuple(_same_poses(sections[0], section) for section in sections),
                tuple(_same_sheet(triads[0], one) for one in triads),
            ))
    return tuple(compared)


def _parameters(
    triad: str, triads: Sequence[StoredTriad | None],
    sections: Sequence[Mapping[str, Any] | None],
) -> Iterator[ComparedParameter]:
    sheets = [_same_sheet(triads[0], one) for one in triads]
    for key in PARAMETERS:
        title = key.split("_")[0]
        comparable = [key == "misalignment_rad" or sheet for sheet in sheets]
        for axis, name in enumerate(AXES):
            yield _compared(f"{title} {name}", unit_of(key, triad), False, [
                None if one is None else (
                    getattr(one, key)[axis], getattr(one, f"{title}_sd")[axis])
                for one in triads
            ], comparable, [_sd_seen_by_one(sections[0], section, key, axis)
                            for section in sections])
    names = dict.fromkeys(name for one in triads if one is not None for name in one.effects)
    for name in names:
        entries = [None if one is None else one.effects.get(name) for one in triads]
        parts = max((entry for entry in entries if entry is not None),
                    key=lambda entry: len(entry["values"]))
        for i, (part, unit) in enumerate(_parts(name, triad, parts)):
            yield _compared(f"{name} {part}".strip(), unit, True, [
                None if entry is None else (entry["values"][i], entry["sd"][i])
                for entry in entries
            ])


def _parts(name: str, triad: str, entry: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What the parameters of an effect are called, and their units; the last may be its shape."""
    count, unit = len(entry["values"]), str(entry["unit"])
    try:
        effect = find_effect(name)
    except UnknownEffect:  # a user's
        return [(str(i + 1) if count > 1 else "", unit) for i in range(count)]
    parts = [(part, unit) for part in effect.parameters]
    if effect.shape is not None:
        parts.append((effect.shape.name, effect.shape.unit))
    return parts[:count]


def _compared(
    name: str, unit: str, is_effect: bool,
    entries: Sequence[tuple[float | None, float | None] | None],
    comparable: Sequence[bool] | None = None, unseen: Sequence[float] | None = None,
) -> ComparedParameter:
    values, sds = ([_number(None if entry is None else entry[k]) for entry in entries]
                   for k in range(2))
    apart = [_apart(values[0], sds[0], value, sd, 0.0 if unseen is None else unseen[k])
             if comparable is None or comparable[k] else None
             for k, (value, sd) in enumerate(zip(values, sds, strict=True))]
    return ComparedParameter(name, unit, is_effect, tuple(values), tuple(sds), tuple(apart))


def _apart(
    first: float | None, first_sd: float | None, value: float | None, sd: float | None,
    unseen: float,
) -> float | None:
    if first is None or first_sd is None or value is None or sd is None:
        return None
    sd_of_difference = math.hypot(first_sd, sd, unseen)
    return None if sd_of_difference == 0 else (value - first) / sd_of_difference


def _sd_seen_by_one(
    first: Mapping[str, Any] | None, other: Mapping[str, Any] | None, key: str, axis: int
) -> float:
    """What an sd lacks of the effects that one of two calibrations can see and the other cannot."""
    parts = [{} if one is None else one["sd_parts_if_typical"] for one in (first, other)]
    alone = [part[name][key][axis] for part, rest in (parts, parts[::-1]) for name in part
             if name not in rest]
    return math.hypot(*(sd for sd in alone if sd is not None))


def _number(value: float | None) -> float | None:
    return None if value is None else number(value)


def comparison_json(
    results: Sequence[Stored], compared: Sequence[ComparedTriad], ageing: Mapping[str, Any]
) -> dict[str, Any]:
    """The comparison for programs, SI; lists are in the order of ``results``.

    ``ageing`` holds the :class:`pipeline.results.ageing.Ageing` of each triad, or None.
    """
    return {
        "results": [str(stored.path) for stored in results],
        "titles": [stored.contents["title"] for stored in results],
    } | {
        one.triad: {
            "model": [None if s is None else s["model"] for s in one.sections],
            "verdict": [None if s is None else s["diagnosis"]["verdict"] for s in one.sections],
        } | {
            key: [None if s is None else s[key] for s in one.sections]
            for key in ("residual_rms", "loo_rms", "chi2", "dof")
        } | {
            "same_poses": one.same_poses,
            "ageing": ageing[one.triad] and _finite(asdict(ageing[one.triad])),
            "error_on_poses": one.error_on_poses,
            "parameters": [
                {"name": p.name, "unit": p.unit, "values": p.values, "sd": p.sds,
                 "apart_sd": p.apart_sd}
                for p in one.parameters
            ],
        }
        for one in compared
    }


# --- each calibration on the poses of all --------------------------------------------------------


def _finite(entry: Mapping[str, Any]) -> dict[str, Any]:
    """The entry with null for a time that never comes."""
    due = [one if math.isfinite(one) else None for one in entry["due_days"]]
    return {**entry, "due_days": due}


def _errors_on(
    section: Mapping[str, Any] | None, recorded_by: StoredTriad | None,
    triads: Sequence[StoredTriad | None],
) -> tuple[float | None, ...]:
    """Rms error of every calibration on the poses of one section, SI."""
    if section is None or recorded_by is None:
        return (None,) * len(triads)
    return tuple(
        _error_on(section["poses"], triad)
        if triad is not None and _same_sheet(recorded_by, triad) else None
        for triad in triads
    )


def _error_on(poses: Sequence[Mapping[str, Any]], triad: StoredTriad) -> float | None:
    """Rms error of ``triad`` on poses with the readings of a triad with its data sheet."""
    errors = StoredPoses.of(triad.name, poses).errors(triad.correction)
    return None if errors is None else rms(errors)


def _same_sheet(one: StoredTriad | None, other: StoredTriad | None) -> bool:
    """Whether a count of the one is a count of the other."""
    return one is not None and other is not None and one.correction.spec == other.correction.spec


def _same_poses(one: Mapping[str, Any] | None, other: Mapping[str, Any] | None) -> bool:
    """Whether two sections are of the same readings."""
    if one is None or other is None:
        return False
    a, b = ([pose["reading"] for pose in section["poses"]] for section in (one, other))
    return bool(a == b)

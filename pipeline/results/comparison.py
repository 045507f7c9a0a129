"""Several stored calibrations of one sensor side by side: parameters, errors, each on all poses.

    error of A on the poses of B = rms of |A(reading of B)| - reference of B

The error of a calibration on the poses of another session is its error in use; its own residual is
smaller, because it was fitted to it.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import ndtri

from calib.errors import CalibrationError
from calib.fit.triad.correction import Correction
from calib.poses.conditions import Conditions
from calib.poses.imu_log import AXES, BoolArray, FloatArray, Triad
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.results.json_values import Json, json_value, numbers, unit_of
from pipeline.results.names import PARAMETERS
from pipeline.results.read import Stored, StoredTriad

if TYPE_CHECKING:
    from pipeline.results.ageing import Ageing


CHANCE = 0.01
"""Probability that a change is reported for a sensor that has not changed. A choice."""
UNKNOWN = (None, None)  #: value and sd of a parameter that a calibration does not have


@dataclass(frozen=True, eq=False)
class ComparedParameter:
    """One parameter of all S calibrations; NaN where one does not have it.

    ``values`` and ``sds`` (S,) are in ``unit``. ``apart_sd`` (S,) is the distance from the first
    calibration in sds of the difference, NaN where one of the two was not fitted. What only one of
    them cannot see is in that sd, at the size typical of the sensor. ``is_effect`` is whether it is
    none of the nine parameters.
    """

    name: str
    unit: str
    is_effect: bool
    values: FloatArray
    sds: FloatArray
    apart_sd: FloatArray


@dataclass(frozen=True, eq=False)
class ComparedTriad:
    """One triad of all S calibrations, in the order of the results.

    Attributes
    ----------
    triad : str
    stored : tuple of StoredTriad or None
        None where a session has no such.
    parameters : tuple of ComparedParameter
    """

    triad: Triad
    stored: tuple[StoredTriad | None, ...]
    parameters: tuple[ComparedParameter, ...]

    @cached_property
    def error_on_poses(self) -> FloatArray:
        """Error of calibration a on the poses of b in row b, column a, rms, SI, (S, S).

        NaN where one of its effects needs conditions that the results of b lack.
        """
        return np.array([[_error_on(one, by) for by in self.stored] for one in self.stored])

    def farthest(self, k: int) -> ComparedParameter | None:
        """The parameter of calibration k that differs most from that of the first, in sds."""
        known = [one for one in self.parameters if np.isfinite(one.apart_sd[k])]
        return max(known, key=lambda one: abs(float(one.apart_sd[k])), default=None)

    def chance_limit_sd(self, *others: int) -> float:
        """Sds that the farthest of so many parameters of the other calibrations exceeds by chance
        alone in one of a hundred cases (Šidák, *Rectangular Confidence Regions for the Means of
        Multivariate Normal Distributions*, 1967).
        """
        count = sum(int(np.isfinite(one.apart_sd[[*others]]).sum()) for one in self.parameters)
        return float(-ndtri((1 - (1 - CHANCE) ** (1 / max(count, 1))) / 2))

    def is_same_sheet(self, k: int) -> bool:
        """Whether counts of calibration k and of the first are comparable."""
        return _is_same_sheet(self.stored[0], self.stored[k])

    def is_same_poses(self, k: int) -> bool:
        """Whether calibration k and the first have a reading in common."""
        first, other = self.stored[0], self.stored[k]
        return first is not None and other is not None and share_a_reading(*(
            [pose.reading for pose in one.section.poses] for one in (first, other)))


def compare_calibrations(results: Sequence[Stored]) -> tuple[ComparedTriad, ...]:
    """Every triad that two of the ``results`` have.

    Parameters
    ----------
    results : sequence of Stored
        Two or more results.json of one sensor.
    """
    compared = []
    for triad in TRIAD_KINDS:
        stored = tuple(next((t for t in one.triads if t.name == triad), None) for one in results)
        if sum(one is not None for one in stored) >= 2:
            compared.append(ComparedTriad(triad, stored, tuple(_parameters(triad, stored))))
    return tuple(compared)


def _parameters(
    triad: str, stored: Sequence[StoredTriad | None]
) -> Iterator[ComparedParameter]:
    sheets = np.array([_is_same_sheet(stored[0], one) for one in stored])
    spec = next(one.correction.spec for one in stored if one is not None)
    for key, i in product(PARAMETERS, range(len(AXES))):
        yield _compared(f"{key.split('_')[0]} {AXES[i]}", unit_of(key, triad, spec), [
            UNKNOWN if one is None else (getattr(one.section.parameters, key)[i],
                                         getattr(one.section.sd, key)[i]) for one in stored
        ], sheets | (key == "misalignment_rad"), [
            _sd_seen_by_one(stored[0], one, key, i) for one in stored])
    effects = [{} if one is None else one.section.effects for one in stored]
    for name in dict.fromkeys(name for one in effects for name in one):
        entries = [one.get(name) for one in effects]
        known = [one.parts_of(name) for one, entry in zip(stored, entries, strict=True)
                 if one is not None and entry is not None]
        parts = max(known, key=len)
        for i, (part, unit) in enumerate(parts):
            yield _compared(f"{name} {part}".strip(), unit, [
                UNKNOWN if entry is None else (entry.values[i], entry.sd[i]) for entry in entries])


def _compared(
    name: str, unit: str, entries: Sequence[tuple[float | None, float | None]],
    is_comparable: BoolArray | None = None, unseen: Sequence[float] | None = None,
) -> ComparedParameter:
    value, sd = np.array(entries, float).T
    apart_sd = np.hypot(np.hypot(sd, sd[0]), 0.0 if unseen is None else unseen)
    apart = (value - value[0]) / np.where(apart_sd > 0, apart_sd, np.nan)
    if is_comparable is not None:
        apart[~is_comparable] = np.nan
    return ComparedParameter(name, unit, is_comparable is None, value, sd, apart)


def _sd_seen_by_one(
    first: StoredTriad | None, other: StoredTriad | None, key: str, axis: int
) -> float:
    """Part missing from an sd by effects that only one of two calibrations can see."""
    parts = [{} if one is None else one.section.sd_parts_if_typical for one in (first, other)]
    alone = [getattr(part[name], key)[axis] for part, rest in (parts, parts[::-1])
             for name in part if name not in rest]
    return math.hypot(*(sd for sd in alone if sd is not None))


def comparison_json(
    results: Sequence[Stored], compared: Sequence[ComparedTriad],
    ageing: Mapping[str, "Ageing | None"]
) -> Json:
    """The comparison for programs, SI; lists are in the order of ``results``.

    ``ageing`` is the rate of change of each triad, where that is known.
    """
    return {
        "results": [str(stored.path) for stored in results],
        "titles": [stored.contents.title for stored in results],
    } | {
        one.triad: {
            "model": [of and of.section.model for of in one.stored],
            "verdict": [of and of.section.diagnosis.verdict for of in one.stored],
        } | {
            key: [of and getattr(of.section, key) for of in one.stored]
            for key in ("residual_rms", "loo_rms", "chi2", "dof")
        } | {
            "same_poses": [*map(one.is_same_poses, range(len(results)))],
            "ageing": json_value(asdict(moved)) if (moved := ageing[one.triad]) else None,
            "error_on_poses": json_value(one.error_on_poses),
            "parameters": [
                {"name": p.name, "unit": p.unit, "values": numbers(p.values),
                 "sd": numbers(p.sds), "apart_sd": numbers(p.apart_sd)}
                for p in one.parameters
            ],
        }
        for one in compared
    }


# --- each calibration on the poses of all --------------------------------------------------------


def _error_on(recorded: StoredTriad | None, by: StoredTriad | None) -> float:
    """Rms error of the calibration ``by`` on the poses of another of its data sheet, SI; or NaN."""
    if recorded is None or by is None or not _is_same_sheet(recorded, by):
        return math.nan
    errors = StoredPoses.of(recorded).errors(by.correction)
    return math.nan if errors is None else rms(errors)


def _is_same_sheet(one: StoredTriad | None, other: StoredTriad | None) -> bool:
    """Whether counts of the two are comparable."""
    return one is not None and other is not None and one.correction.spec == other.correction.spec


@dataclass(frozen=True, eq=False)
class StoredPoses:
    """The n poses of one triad with a known length of its vector: gravity, or the plate's rate.

    ``at`` are their conditions with the nominal readings, ``reference`` (n,) the lengths and
    ``sd`` (n,) those of their errors, SI.
    """

    label: tuple[str, ...]
    at: Conditions
    reference: FloatArray
    sd: FloatArray

    @classmethod
    def of(cls, triad: StoredTriad) -> "StoredPoses":
        """The poses of a triad's section, without those at rest of a gyroscope."""
        used = [pose for pose in triad.section.poses if pose.reference != 0]
        names = dict.fromkeys(name for pose in used for name in pose.columns)
        reading = np.array([pose.reading for pose in used], float).reshape(-1, 3)
        force = reading if triad.name == "accelerometer" else np.array(
            [pose.force_m_s2 or [None] * 3 for pose in used], float).reshape(-1, 3)
        at = Conditions.of_vectors(
            reading, {name: _values(pose.columns.get(name) for pose in used) for name in names},
            force=force, time_s=_values(pose.time_s for pose in used),
            spin_rad_s=_values(pose.spin_rad_s for pose in used))
        return cls(tuple(pose.label for pose in used), at,
                   np.abs(_values(pose.reference for pose in used)),
                   _values(pose.sd for pose in used))

    def errors(self, correction: Correction) -> FloatArray | None:
        """Corrected length less the reference, SI, (n,), by the part of the sensor alone.

        None without such poses, or if an effect needs conditions that these results lack.
        """
        if not self.label:
            return None
        try:
            corrected = correction.sensor_part().correct(self.at)
        except CalibrationError:
            return None
        error = np.linalg.norm(corrected, axis=1) - self.reference
        return error if np.isfinite(error).all() else None


def share_a_reading(
    one: Iterable[Sequence[float | None] | FloatArray],
    other: Iterable[Sequence[float | None] | FloatArray],
) -> bool:
    """Whether two sessions have the mean reading of a pose in common, (3,) each, bit by bit.

    No two measurements give the same; a pose left out of one of two fits makes no other session.
    """
    return not {*map(tuple, one)}.isdisjoint(map(tuple, other))


def rms(values: FloatArray) -> float:
    """Root mean square, in the unit of ``values`` (n,)."""
    return float(np.sqrt(np.mean(values**2)))


def _values(values: Iterable[float | None]) -> FloatArray:
    return np.array([*values], float)

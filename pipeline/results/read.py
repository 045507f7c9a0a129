"""results.json read back: what other commands need of an earlier run."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from calib.effects.effect import Effect
from calib.errors import CalibrationError
from calib.fit.model import Model
from calib.fit.parameters import alignment, triad_parameters
from calib.fit.triad.correction import Correction
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.errors import UnreadableInput
from pipeline.results.names import PARAMETERS, RESULTS_NAME
from pipeline.results.noise import read_json
from pipeline.results.schema import FORMAT
from pipeline.results.schema.file import results_file
from pipeline.results.schema.types import problems_of

SAME = 1e-6  #: relative difference of what is stored twice: no worse in files of other programs
NONE = 1e-12  #: size of a parameter that is 0 in one of the two places, in its unit


@dataclass(frozen=True, eq=False)
class StoredTriad:
    """One calibrated triad as results.json has it.

    Parameters
    ----------
    name : str
        Which triad.
    correction : Correction
    misalignment_rad, misalignment_sd : array, shape (3,)
        rad; all sds are NaN where a parameter was not fitted.
    bias_counts, bias_sd : array, shape (3,)
        Counts.
    scale_counts_per_unit, scale_sd : array, shape (3,)
        Counts per m/s² or per rad/s.
    effects : mapping of str to object
        Those added to the nine parameters, as the file has them.
    """

    name: str
    correction: Correction
    misalignment_rad: FloatArray
    bias_counts: FloatArray
    scale_counts_per_unit: FloatArray
    misalignment_sd: FloatArray
    bias_sd: FloatArray
    scale_sd: FloatArray
    effects: Mapping[str, Any]

    @property
    def alignment(self) -> FloatArray:
        """T of Angrisano et al. eq. (2), shape (3, 3), no unit."""
        return alignment(self.misalignment_rad)

    @property
    def units_per_count(self) -> FloatArray:
        """The diagonal of K, m/s² or rad/s per count, shape (3,)."""
        return 1 / self.scale_counts_per_unit


@dataclass(frozen=True, eq=False)
class Stored:
    """A results.json: where it is, everything in it, and its triads."""

    path: Path
    contents: Mapping[str, Any]
    triads: tuple[StoredTriad, ...]

    @property
    def folder(self) -> Path:
        """Where it is."""
        return self.path.parent

    @property
    def mounting_rotation(self) -> FloatArray | None:
        """Rotation R (3, 3) from the axes of the vehicle to the sensor's; None if not measured."""
        section = self.contents.get("installation")
        return None if section is None else np.array(section["rotation"], dtype=float)

    @property
    def gyroscope_to_accelerometer_rad(self) -> FloatArray | None:
        """Rotation vector between the frames of the triads, rad, (3,); None if not measured."""
        angles = (self.contents.get("gyroscope") or {}).get("frame_to_accelerometer_rad")
        return None if angles is None else np.array(angles, dtype=float)


def load_results(path: Path, allow_python: bool = False) -> Stored:
    """Read ``results.json``; ``path`` is the file or its folder.

    ``allow_python`` lets the Python files of user-defined effects run; without it these effects
    are there by name and cannot be evaluated.

    Raises
    ------
    UnreadableInput
        It is missing, damaged, or was written by a program of another format.
    """
    path = path / RESULTS_NAME if path.is_dir() else path
    contents = read_json(path, RESULTS_NAME, "pipeline run")
    if not isinstance(contents, dict) or contents.get("format") != FORMAT:
        kind = contents.get("format") if isinstance(contents, dict) else None
        raise UnreadableInput(
            f"{path}: format {kind!r} found, {FORMAT} is expected. Write it anew with this "
            f"version's `pipeline run`."
        )
    if problems := problems_of(results_file(), contents):
        raise _not_ours(path, problems)
    try:
        triads = tuple(
            _triad(name, contents[name], path.parent, allow_python)
            for name in TRIAD_KINDS
            if contents.get(name) is not None
        )
    except (ValueError, CalibrationError) as error:
        raise _not_ours(path, str(error)) from error
    return Stored(path, contents, triads)


def _not_ours(path: Path, problem: str) -> UnreadableInput:
    return UnreadableInput(
        f"{path}: a part is missing or is not what `pipeline run` writes ({problem}). Write it "
        f"anew with `pipeline run`."
    )


def _triad(
    name: Triad, section: Mapping[str, Any], folder: Path, allow_python: bool
) -> StoredTriad:
    value, sd, stored = section["parameters"], section["sd"], section["correction"]
    sheet = stored["sheet"]
    full_scale = math.inf if sheet["full_scale"] is None else float(sheet["full_scale"])
    spec = TriadSpec(full_scale, sheet["bits"], sheet["encoding"], sheet["si_per_unit"])
    user_defined = _user_effects(stored["own_effects"], name, folder, allow_python)
    model = Model.of(stored["model"], user_defined)
    theta = _array(stored["theta"])
    if len(theta) != model.size:
        raise ValueError(f"{name}: {len(theta)} parameters for a model of {model.size}")
    if missing := [effect.name for effect in model.effects
                   if effect.shape is not None and effect.name not in stored["shapes"]]:
        raise ValueError(f"{name}.correction.shapes.{missing[0]} is missing")
    triad = StoredTriad(
        name=name,
        correction=Correction(spec, model, theta, stored["shapes"]),
        misalignment_rad=_array(value["misalignment_rad"]),
        bias_counts=_array(value["bias_counts"]),
        scale_counts_per_unit=_array(value["scale_counts_per_unit"]),
        misalignment_sd=_array(sd["misalignment_rad"]),
        bias_sd=_array(sd["bias_counts"]),
        scale_sd=_array(sd["scale_counts_per_unit"]),
        effects=section["effects"],
    )
    _require_agreement(triad)
    return triad


def _require_agreement(triad: StoredTriad) -> None:
    """Refuse parameters that are not those of the correction: one of the two was edited.

    Raises
    ------
    ValueError
        Naming the group of parameters, or the effect.
    """
    correction = triad.correction
    model, theta = correction.model, correction.theta
    no_cov = np.zeros((len(theta), len(theta)))
    expected = triad_parameters(model, theta, no_cov, correction.spec)
    for key in PARAMETERS:
        if not np.allclose(getattr(triad, key), getattr(expected, key), rtol=SAME, atol=NONE):
            raise ValueError(f"{triad.name}.parameters.{key} is not that of correction.theta")
    for name, entry in triad.effects.items():
        of_effect = theta[model.positions(
            [effect for effect in model.effects if effect.name == name])]
        values = _array(entry["values"])[: len(of_effect)]
        if not np.allclose(values, of_effect, rtol=SAME, atol=0, equal_nan=True):
            raise ValueError(f"{triad.name}.effects.{name} is not that of correction.theta")


def _user_effects(
    stored: Mapping[str, Any], triad: Triad, folder: Path, allow_python: bool
) -> dict[str, Effect]:
    if not stored:
        return {}
    # pydantic and all, which few calibrations need
    from pipeline.stages.user_effects import stored_effects

    return stored_effects(stored, triad, folder, allow_python)


def _array(values: list[float | None]) -> FloatArray:
    return np.array([math.nan if value is None else value for value in values], float)

"""Reading of results.json for commands that need an earlier run."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.effects.effect import Effect
from calib.errors import CalibrationError
from calib.fit.model import Model
from calib.fit.parameters import TriadParameters, alignment, triad_parameters
from calib.fit.triad.correction import Correction
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, Triad
from pipeline.errors import UnreadableInput
from pipeline.results.names import PARAMETERS, RESULTS_NAME
from pipeline.results.noise import read_json
from pipeline.results.schema import FORMAT
from pipeline.results.schema.file import ResultsFile, results_file
from pipeline.results.schema.triad import TriadSection

SAME = 1e-6  #: relative difference of values stored twice: no worse in files of other programs
NONE = 1e-12  #: size of a parameter that is 0 in one of the two places, in its unit


@dataclass(frozen=True, eq=False)
class StoredTriad:
    """One calibrated triad from results.json.

    Parameters
    ----------
    name : str
        Which triad.
    section : TriadSection
        Its section.
    parameters : TriadParameters
        The nine of the section as arrays, with their sds alone; NaN where one was not fitted.
    correction : Correction
    """

    name: str
    section: TriadSection
    parameters: TriadParameters
    correction: Correction

    def parts_of(self, name: str) -> list[tuple[str, str]]:
        """Name and unit of every value of an added effect; that of its shape comes last."""
        effect = next(one for one in self.correction.model.effects if one.name == name)
        unit = self.section.effects[name].unit.partition("; ")[0]
        parts = [(parameter, unit) for parameter in effect.parameters]
        if effect.shape is not None:
            parts.append((effect.shape.name, effect.shape.unit))
        return parts[: len(self.section.effects[name].values)]

    @property
    def alignment(self) -> FloatArray:
        """T of Angrisano et al. eq. (2), shape (3, 3), no unit."""
        return alignment(self.parameters.misalignment_rad)

    @property
    def end_s(self) -> float:
        """Time of its last pose since the session began, s; NaN where no times are known."""
        return max((pose.time_s for pose in self.section.poses if pose.time_s is not None),
                   default=math.nan)

    @property
    def range_counts(self) -> FloatArray:
        """Lowest and highest reading of every axis, counts or the log's unit, shape (2, 3).

        They are the converter's, infinite in physical units, or where a pose is cut off.
        """
        spec = self.correction.spec
        low, high = spec.count_range if spec.bits else (-math.inf, math.inf)
        ends = np.repeat([[low], [high]], 3, axis=1)
        for pose in self.section.excluded:
            level = np.array(pose.cut_off_counts or (None,) * 3, float)
            is_high = level > spec.nominal_bias_counts
            ends[1] = np.fmin(ends[1], np.where(is_high, level, np.nan))
            ends[0] = np.fmax(ends[0], np.where(is_high, np.nan, level))
        return ends

    @property
    def units_per_count(self) -> FloatArray:
        """The diagonal of K, m/s² or rad/s per count, shape (3,)."""
        return 1 / self.parameters.scale_counts_per_unit


@dataclass(frozen=True, eq=False)
class Stored:
    """A results.json: its path, its contents, and its triads."""

    path: Path
    contents: ResultsFile
    triads: tuple[StoredTriad, ...]

    @property
    def folder(self) -> Path:
        """Its folder."""
        return self.path.parent

    @property
    def gravity_m_s2(self) -> float:
        """Gravity of the session, m/s²; standard gravity where no accelerometer was calibrated."""
        accelerometer = self.contents.accelerometer
        return (STANDARD_GRAVITY_M_S2 if accelerometer is None
                else accelerometer.gravity.value_m_s2)

    @property
    def mounting_rotation(self) -> FloatArray | None:
        """Rotation R (3, 3) from the axes of the vehicle to the sensor's; None if not measured."""
        section = self.contents.installation
        return None if section is None else np.array(section.rotation)

    @property
    def gyroscope_to_accelerometer_rad(self) -> FloatArray | None:
        """Rotation vector between the frames of the triads, rad, (3,); None if not measured."""
        gyroscope = self.contents.gyroscope
        angles = None if gyroscope is None else gyroscope.frame_to_accelerometer_rad
        return None if angles is None else np.array(angles)


def load_results(path: Path, allow_python: bool = False) -> Stored:
    """Read ``results.json``; ``path`` is the file or its folder.

    ``allow_python`` lets the Python files of user-defined effects run; without it these effects are
    present by name and cannot be evaluated.

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
    try:
        results = results_file().parsed(contents)
        triads = tuple(_triad(name, section, path.parent, allow_python)
                       for name, section in results.triads.items())
    except (ValueError, CalibrationError) as error:
        raise UnreadableInput(
            f"{path}: a part is missing or is not what `pipeline run` writes ({error}). Write it "
            f"anew with `pipeline run`.") from error
    return Stored(path, results, triads)


def _triad(
    name: Triad, section: TriadSection, folder: Path, allow_python: bool
) -> StoredTriad:
    stored, sheet = section.correction, section.correction.sheet
    full_scale = math.inf if sheet.full_scale is None else sheet.full_scale
    spec = TriadSpec(full_scale, sheet.bits, sheet.encoding, sheet.si_per_unit)
    defined: dict[str, Effect] = {}
    if stored.own_effects:  # the stages and all, 0.4 s, which few calibrations need
        from pipeline.results.stored_effects import stored_effects

        defined = stored_effects(stored.own_effects, name, folder, allow_python)
    model = Model.of(stored.model, defined)
    theta = np.array(stored.theta)
    if len(theta) != model.size:
        raise ValueError(f"{name}: {len(theta)} parameters for a model of {model.size}")
    if missing := [effect.name for effect in model.effects
                   if effect.shape is not None and effect.name not in stored.shapes]:
        raise ValueError(f"{name}.correction.shapes.{missing[0]} is missing")
    values, sds = (np.array([getattr(part, key) for key in PARAMETERS], float)
                   for part in (section.parameters, section.sd))
    parameters = TriadParameters(values[0], values[1], values[2], np.diag(sds.ravel() ** 2))
    triad = StoredTriad(name, section, parameters, Correction(spec, model, theta, stored.shapes))
    _require_agreement(triad)
    return triad


def _require_agreement(triad: StoredTriad) -> None:
    """Refuse parameters that differ from those of the correction: one of the two was edited.

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
        if not np.allclose(getattr(triad.parameters, key), getattr(expected, key), rtol=SAME,
                           atol=NONE):
            raise ValueError(f"{triad.name}.parameters.{key} is not that of correction.theta")
    for name, effect in triad.section.effects.items():
        of_effect = theta[model.positions([one for one in model.effects if one.name == name])]
        values = np.array(effect.values, float)[: len(of_effect)]
        if not np.allclose(values, of_effect, rtol=SAME, atol=0, equal_nan=True):
            raise ValueError(f"{triad.name}.effects.{name} is not that of correction.theta")

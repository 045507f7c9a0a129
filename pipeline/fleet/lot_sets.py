"""From the rows of a table to the pose sets of a triad, sensor by sensor.

The first sound sensor with a sequence of poses is processed as a session (:mod:`pipeline.stages`):
its references, sds and checks are those of ``pipeline run``. Another with the same poses in the
same runs differs from it in its measurements alone, and is processed so where their size shows that
a session would be refused.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from calib.errors import CalibrationError, Undetermined
from calib.fit.least_squares.solver import fit_sets
from calib.fit.model import Model
from calib.fit.triad.correction import Correction
from calib.lot import SensorPoses
from calib.poses.averaging.pose_mean import (
    SD,
    TIME,
    is_read,
    nominal_means,
    tabled_poses,
    triad_columns,
)
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import TRIADS, FloatArray, IntArray, Triad
from calib.poses.pose_set import PoseSet
from calib.poses.reference import PLAUSIBLE_RATIO
from pipeline.config.load import Config, config_from
from pipeline.config.sensor import sensor_specs
from pipeline.config.yaml_text import PathTo, YamlSource, read_source
from pipeline.errors import ConfigError, UnreadableInput
from pipeline.fleet.lot_table import SensorRows, sensor_blocks
from pipeline.stages.context import RunContext
from pipeline.stages.plate_settings import measure_rates
from pipeline.stages.rate import SettingRate
from pipeline.stages.recordings import Recording, Recordings
from pipeline.stages.references import gravity_of
from pipeline.stages.session_logs import sections_by_setting
from pipeline.stages.triad_poses import accelerometer_poses, gyroscope_poses
from pipeline.stages.user_effects import user_effects


def load_design(path: Path, table: Path) -> Config:
    """The configuration of one sensor, whose poses are the rows of ``table``.

    Raises
    ------
    ConfigError
        With a paragraph for every mistake in the file.
    """
    source = read_source(path)
    return config_from(_with_table(source, str(table.absolute())), files_may_be_missing=True)


def _with_table(source: YamlSource, table: str) -> YamlSource:
    """The design whose poses are those of ``table``; it may not name poses of its own."""
    values: dict[str, Any] = dict(source.values)
    poses, refused = {"means": table}, list[PathTo]()
    for triad in TRIADS:
        section = values.get(triad)
        if isinstance(section, dict) and isinstance(section.get("runs"), list):
            refused += [(triad, "runs", i, "poses") for i, run in enumerate(section["runs"])
                        if isinstance(run, dict) and "poses" in run]
            runs = [{**run, "poses": poses} if isinstance(run, dict) else run
                    for run in section["runs"]]
            values[triad] = {**section, "runs": runs}
        elif isinstance(section, dict):
            refused += [(triad, "poses")] if "poses" in section else []
            values[triad] = {**section, "poses": poses}
    if refused:
        raise ConfigError(*(source.problem(path, "a design has no poses of its own: they are the "
                                           "rows of the table. Take the key out.")
                            for path in refused))
    return replace(source, values=values)


Pattern = tuple[tuple[str, ...], tuple[str, ...]]


@dataclass(frozen=True, eq=False)
class _Example:
    """The poses of one sensor as in a session, and the row of each of them (n,)."""

    poses: PoseSet
    rows: IntArray


@dataclass(frozen=True, eq=False)
class LotSets:
    """The pose sets of a lot.

    Parameters
    ----------
    design : Config
    table : Path
    rates : mapping of str to SettingRate
        The plate's, by setting.
    allow_python : bool
        Whether Python files that the design names for effects may run.
    refusals : dict of (str, str) to str
        Why the rows of a sensor are no poses, by the triad and its name.
    """

    design: Config
    table: Path
    rates: Mapping[str, SettingRate]
    allow_python: bool = False
    refusals: dict[tuple[Triad, str], str] = field(default_factory=dict)
    _passed: set[Triad] = field(default_factory=set)

    @classmethod
    def of(cls, design: Config, table: Path, context: RunContext) -> "LotSets":
        """The lot of a table; measures the rates of the design that are filmed.

        Raises
        ------
        UnreadableVideo, RateRefused, UnreadableInput
            A clip of the design cannot be read, or its rate cannot be determined.
        """
        return cls(design, table, measure_rates(design, context), context.allow_python)

    @property
    def triads(self) -> list[Triad]:
        """The triads that the design calibrates, accelerometer first."""
        return list(self.design.triads)

    def spec(self, triad: Triad) -> TriadSpec:
        """The data sheet of a triad."""
        spec = sensor_specs(self.design.sensor).get(triad)
        assert spec is not None
        return spec

    def model(self, triad: Triad) -> Model:
        """The model of a triad's section."""
        section = getattr(self.design, triad)
        return Model.of(section.model, user_effects(self.design, triad, self.allow_python))

    def blocks(self, triad: Triad) -> Iterator[list[SensorPoses]]:
        """The pose sets of one triad, block by block; sensors that have none are ``refusals``.

        Those of a gyroscope have the specific force by the sensor's own accelerometer, calibrated.

        Raises
        ------
        UnreadableInput
            The table cannot be read, or a reading or an sd is no number.
        """
        needed = [name for one in self.triads for prefix in ("", SD)
                  for name in triad_columns(one, prefix)]
        settings = {setting.rate for setting in sections_by_setting(self.design)}
        examples: dict[tuple[Triad, Pattern], _Example] = {}
        for sensors in sensor_blocks(
                self.table, needed, settings, is_sorted=triad in self._passed):
            _require_numbers(sensors, needed, self.table)
            corrections = {}
            if triad == "gyroscope" and "accelerometer" in self.triads:
                beside = self._block("accelerometer", sensors, examples, {})
                corrections = self._corrections(beside)
            block = self._block(triad, sensors, examples, corrections)
            if block:
                yield block
        self._passed.add(triad)

    def _block(
        self, triad: Triad, sensors: Sequence[SensorRows],
        examples: dict[tuple[Triad, Pattern], _Example],
        corrections: Mapping[str, Correction],
    ) -> list[SensorPoses]:
        block = []
        for rows in sensors:
            key = triad, (rows.pose, rows.run)
            try:
                if key not in examples:
                    examples[key] = self._example(triad, rows)
                poses = self._measured(triad, examples[key], rows, corrections.get(rows.sensor))
                size = np.linalg.norm(poses.reading, axis=1)[~poses.reference.is_null]
                typical = np.median(size / poses.reference.magnitude[~poses.reference.is_null])
                if not 1 / PLAUSIBLE_RATIO < typical < PLAUSIBLE_RATIO:
                    self._example(triad, rows)
                block.append(SensorPoses(rows.sensor, poses, rows.station))
            except CalibrationError as error:
                self.refusals[triad, rows.sensor] = str(error)
        return block

    def _corrections(self, block: Sequence[SensorPoses]) -> dict[str, Correction]:
        """Corrections of the accelerometers of a block, by sensor."""
        spec, model = self.spec("accelerometer"), self.model("accelerometer")
        return {
            block[int(i)].sensor: Correction(
                spec, model, fits.fitted.theta[k],
                {name: float(value[k]) for name, value in fits.fitted.shapes.items()})
            for fits in fit_sets([one.poses for one in block], model) if fits.fitted
            for k, i in enumerate(fits.index)
        }

    def _example(self, triad: Triad, rows: SensorRows) -> _Example:
        """The poses of a sensor as in a session.

        Raises
        ------
        CalibrationError
            They are refused there, or are of other runs than the design's.
        """
        specs = {name: self.spec(name) for name in self.triads}
        means = tabled_poses(rows.pose, rows.numbers, specs)
        recordings, places = {}, {}
        for setting in sections_by_setting(self.design):
            index = np.array([i for i, run in enumerate(rows.run) if run == setting.rate], int)
            if not len(index):
                continue
            recordings[setting] = Recording(tuple(means[i] for i in index), (_begin(rows),),
                                            np.arange(len(index)))
            places[setting.rate] = index
        wanted = [setting.rate for setting in sections_by_setting(self.design)]
        if places.keys() != set(wanted):
            raise Undetermined(f"its rows are of the runs {', '.join(dict.fromkeys(rows.run))}, "
                               f"and the design has {', '.join(wanted)}.")
        if triad == "accelerometer":
            assert self.design.site is not None
            of_triad = accelerometer_poses(
                self.design, Recordings(recordings), gravity_of(self.design.site))
        else:
            plates = {name: rate.plate for name, rate in self.rates.items()}
            of_triad = gyroscope_poses(self.design, plates, Recordings(recordings), None)
        return _Example(of_triad.used, np.concatenate(
            [places[run] for run, _ in of_triad.recorded]))

    def _measured(
        self, triad: Triad, example: _Example, rows: SensorRows, accelerometer: Correction | None
    ) -> PoseSet:
        """The example with the measurements of this sensor."""
        at, poses = example.rows, example.poses
        measured = {name: nominal_means(rows.pose, rows.numbers, name, self.spec(name))
                    for name in self.triads}
        reading, sd = measured[triad]
        force = measured["accelerometer"][0][at] if "accelerometer" in measured else poses.force
        other: FloatArray | None = poses.other_reading
        for beside in measured.keys() - {triad}:
            other = measured[beside][0][at]
        time_s = poses.time_s
        if TIME in rows.numbers and np.isfinite(poses.time_s).all():
            time_s = rows.numbers[TIME][at] - _begin(rows)
        columns = {name: values[at] for name, values in rows.numbers.items() if not is_read(name)}
        changed = replace(poses, reading=reading[at], sd=sd[at], force=force, time_s=time_s,
                          other_reading=other, run_time_s=time_s, columns=columns)
        if accelerometer is None:
            return changed
        return replace(changed, force=accelerometer.correct(
            changed.accelerometer_conditions(force)))


def _begin(rows: SensorRows) -> float:
    """Start of the session of a sensor, s; 0 where no time is stated."""
    time_s = rows.numbers.get(TIME, np.zeros(1))
    return float(np.nanmin(time_s)) if np.isfinite(time_s).any() else 0.0


def _require_numbers(sensors: Sequence[SensorRows], needed: Sequence[str], table: Path) -> None:
    """Refuse readings and sds that are no numbers, with the sensor and the pose."""
    for name in needed:
        is_sd = name.startswith(SD)
        whole = np.concatenate([rows.numbers[name] for rows in sensors])
        wrong = ~(np.isfinite(whole) & ((whole > 0) if is_sd else True))
        if wrong.any():
            rows, place = [(rows, place) for rows in sensors
                           for place in range(len(rows.pose))][int(np.argmax(wrong))]
            raise UnreadableInput(
                f"{table.name}: sensor {rows.sensor}, {rows.pose[place]}: column {name}: found "
                f"{rows.numbers[name][place]:g}, {'a positive' if is_sd else 'a finite'} number is "
                f"expected.")

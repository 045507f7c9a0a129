"""results.json: the results of a run, for programs.

SI units, arrays in the order x, y, z, null for undetermined values. The same input gives the same
file, byte for byte: it contains no time of day and no absolute path.
"""

import hashlib
import json

import numpy as np

from calib.mounting.both_orders import OrderTrial
from calib.mounting.mounting import Mounting
from calib.poses.imu_log import TRIADS
from pipeline.config.load import Config
from pipeline.logs.columns import Renamed
from pipeline.logs.formats.kinds import split_member
from pipeline.results.inputs import config_name, inputs_sha256
from pipeline.results.json_values import Json
from pipeline.results.rate import rate_section
from pipeline.results.schema import FORMAT
from pipeline.results.schema.file import (
    InstallationResult,
    OrderResult,
    ResultsFile,
    results_file,
)
from pipeline.results.triad import triad_section
from pipeline.stages.run import Outcome


def config_sha256(outcome: Outcome) -> str:
    """The SHA-256 of the configuration's text, which identifies it."""
    return hashlib.sha256(outcome.config.source.text.encode()).hexdigest()


def results_of(outcome: Outcome) -> ResultsFile:
    """The results of a run for results.json."""
    config = outcome.config
    triads = {
        result.triad: triad_section(result, config.effects, config.source.path.parent)
        for result in outcome.triads
    }
    return results_file().of(
        format=FORMAT,
        title=config.title,
        sensor=config.sensor.name,
        config=config_name(config),
        config_sha256=config_sha256(outcome),
        inputs_sha256=inputs_sha256(config),
        session_start_s=outcome.recordings.origin_s if outcome.triads else None,
        rate={name: rate_section(rate) for name, rate in outcome.rates.items()},
        **dict.fromkeys(TRIADS) | triads,
        installation=outcome.installation and installation_section(outcome.installation),
        columns=[row for _, row in stated_columns(config)],
        tables=[table for table, _ in stated_columns(config)],
        sample_rates_hz=[*dict.fromkeys(run.poses.sample_rate_hz for _, run in config.placed_runs()
                                        if run.poses.sample_rate_hz is not None)],
        warnings=outcome.warnings,
    )


def installation_section(mounting: Mounting) -> InstallationResult:
    """The section ``installation`` of results.json; null for quantities that were not measured."""
    yaw, slope = mounting.yaw, mounting.slope
    return InstallationResult.of(
        mounting,
        **_roll_and_pitch(mounting),
        yaw_deg=np.degrees(yaw.yaw_rad) if yaw else None,
        yaw_sd_deg=np.degrees(yaw.sd_rad) if yaw else None,
        floor_rise_deg=np.degrees(slope.rise_rad) if slope else None,
        floor_rise_sd_deg=np.degrees(slope.sd_rad) if slope else None,
        readings=mounting.samples,
        orders=[OrderResult.of(trial, **_roll_and_pitch(trial)) for trial in mounting.orders],
    )


def _roll_and_pitch(trial: Mounting | OrderTrial) -> Json:
    return {"roll_deg": np.degrees(trial.roll_rad), "pitch_deg": np.degrees(trial.pitch_rad),
            "sd_deg": np.degrees(trial.sd_rad)}


def stated_columns(config: Config) -> list[tuple[str, list[str] | dict[str, str]]]:
    """``columns`` of all sections of a configuration, each once, for logs of the same logger; and
    before them the name of the table in a file, empty if the file is one table."""
    stated = dict.fromkeys(
        (split_member(path)[1], row) for _, run in config.placed_runs()
        for i, path in enumerate((*run.poses.files, *run.poses.log, *run.poses.means))
        if (row := run.poses.columns_of(i)) is not None)
    return [(table, dict(row.pairs) if isinstance(row, Renamed) else list(row))
            for table, row in stated]


def results_text(results: ResultsFile) -> str:
    """The text of ``results.json``."""
    return json.dumps(results.as_json(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"

"""A run: five stages, from a configuration to all results. Start reading here.

    config.yaml ─┬─ rates ─────────┬──────────────────────────┐      vision: clip → rate ± sd
                 │                 ▼                          ▼
                 ├──────────── recordings ─┬─ accelerometer ─ gyroscope     calib: poses → fit,
                 │                         └────────│─────────▲             comparison, diagnosis
                 └──────────────────────────────────▼
                                              installation           calib: mounting angles

Each stage is a plain function of the configuration and of earlier results; it returns
None where the configuration has no section for it. :func:`run_stages` calls them in this order.
What is written and shown afterwards is in ``pipeline.results``, ``pipeline.report`` and
``pipeline.console``.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from calib.mounting.mounting import Mounting
from calib.poses.imu_log import Triad
from pipeline.config.load import Config
from pipeline.stages.context import RunContext
from pipeline.stages.fittable import require_fittable
from pipeline.stages.mounting import measure_mounting, reading_at_rest
from pipeline.stages.plate_settings import measure_rates
from pipeline.stages.poses import average_recordings
from pipeline.stages.rate import SettingRate
from pipeline.stages.recordings import Recordings
from pipeline.stages.session_logs import SessionLogs, read_session
from pipeline.stages.triads import TriadResult, triad_input


@dataclass(frozen=True, eq=False)
class Outcome:
    """Results of a run by stage; ``triads`` has the accelerometer first."""

    config: Config
    rates: Mapping[str, SettingRate]
    recordings: Recordings
    triads: tuple[TriadResult, ...]
    installation: Mounting | None

    def triad(self, name: Triad) -> TriadResult | None:
        """The result of one triad; None where it was not calibrated."""
        return next((result for result in self.triads if result.triad == name), None)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings for the user, a paragraph each, in the order of the stages."""
        of_rates = tuple(w for rate in self.rates.values() for w in rate.warnings)
        of_triads = tuple(w for triad in self.triads for w in triad.warnings)
        of_mounting = self.installation.notes if self.installation else ()
        return of_rates + self.recordings.warnings + of_triads + of_mounting


StageResult = SettingRate | Recordings | TriadResult | Mounting
OnResult = Callable[[StageResult], None]
"""Receives the result of a stage before the next one begins."""


def ignore_result(_result: StageResult) -> None:
    """Ignore the results, for runs without an observer."""


def check_session(config: Config) -> SessionLogs:
    """Raise all refusals of :func:`run_stages` that precede the first slow stage; runs no Python.

    Returns
    -------
    SessionLogs
        The logs, which are read by then.

    Raises
    ------
    PipelineError, CalibrationError
        The models do not fit their triads or solvers, or the logs are damaged or contradict the
        configuration or each other.
    """
    require_fittable(config)
    return read_session(config)


def has_same_readings(one: Config, other: Config) -> bool:
    """Whether two configurations state the same logs, clips and data sheets."""
    return (one.source.path, one.sensor, one.rate, [*one.placed_runs()]) == (
        other.source.path, other.sensor, other.rate, [*other.placed_runs()])


def has_same_model(one: Config, other: Config, triad: Triad) -> bool:
    """Whether two configurations with the same readings calibrate ``triad`` in the same way."""
    return (one.triads.get(triad), one.effects, one.covariates, one.site, one.certificate) == (
        other.triads.get(triad), other.effects, other.covariates, other.site, other.certificate)


def average_session(
    config: Config, context: RunContext, on_result: OnResult = ignore_result
) -> tuple[Mapping[str, SettingRate], Recordings]:
    """The first stages, which need no model: the plate's rates and the poses.

    Raises
    ------
    PipelineError, CalibrationError, VisionError
        As :func:`run_stages`.
    """
    logs = check_session(config)
    rates = measure_rates(config, context)
    for rate in rates.values():
        on_result(rate)
    recordings = average_recordings(config, logs, rates)
    on_result(recordings)
    return rates, recordings


def run_stages(
    config: Config, context: RunContext, on_result: OnResult = ignore_result,
    before: Outcome | None = None,
) -> Outcome:
    """Run every stage of a configuration.

    Parameters
    ----------
    config : Config
        Checked; the files it names exist.
    context : RunContext
        The cache of phase tracks, the progress display, what is allowed.
    on_result : callable
        Receives the result of every stage at once: of each plate setting and triad.
    before : Outcome, optional
        Of the same session with another model: results independent of the model are reused.

    Raises
    ------
    PipelineError, CalibrationError, VisionError
        The first stage that refuses ends the run.
    """
    if before is not None and has_same_readings(before.config, config):
        require_fittable(config)
        rates, recordings = before.rates, before.recordings
    else:
        before = None
        rates, recordings = average_session(config, context, on_result)

    plates = {name: rate.plate for name, rate in rates.items()}
    results: dict[Triad, TriadResult] = {}
    for triad in config.triads:
        if before is not None and not has_same_model(before.config, config, triad):
            before = None  # of this triad and of those that it is compared with
        known = None if before is None else before.triad(triad)
        if known is not None:
            results[triad] = known
            continue
        beside = results.get("accelerometer")
        results[triad] = triad_input(
            triad, config, plates, recordings, beside.calibration if beside else None,
            allow_python=context.allow_python).result()
        on_result(results[triad])

    installation = None
    if "accelerometer" in results:
        accelerometer = results["accelerometer"]
        installation = measure_mounting(config, accelerometer.calibration, accelerometer.gravity,
                                        reading_at_rest(config, recordings))
    if installation is not None:
        on_result(installation)

    return Outcome(config, rates, recordings, tuple(results.values()), installation)

"""The rows of the table: one for each triad of a session, numbers as results.json has them."""

from collections.abc import Iterator, Mapping
from typing import Any

from calib.poses.imu_log import AXES
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.config.load import Config
from pipeline.fleet.sessions import FleetSession
from pipeline.results.names import PARAMETERS
from pipeline.text.plain import one_line

Row = dict[str, Any]

SIZE, SIZE_SD = "size", "size_sd"
"""Before the name of an effect: columns with its largest parameter, SI, and the sd of that."""


def rows_of_results(session: FleetSession, results: Mapping[str, Any]) -> tuple[Row, ...]:
    """A row for each triad that was calibrated."""
    return tuple(
        _head(session, triad) | {"exit_code": 0, "reason": ""}
        | _session_columns(results) | _triad_columns(results[triad])
        for triad in TRIAD_KINDS if results.get(triad) is not None
    )


def rows_of_failure(
    session: FleetSession, config: Config | None, exit_code: int, reason: str
) -> tuple[Row, ...]:
    """A row for each triad that was to be calibrated, or one, with the reason why it is not."""
    triads = [] if config is None else list(config.triads)
    return tuple(_head(session, triad) | {"exit_code": exit_code, "reason": one_line(reason)}
                 for triad in (triads or [""]))


def _head(session: FleetSession, triad: str) -> Row:
    return {"session": session.name, "sensor": session.sensor, "triad": triad}


def _session_columns(results: Mapping[str, Any]) -> Row:
    return {
        "title": results["title"],
        "sensor_name": results["sensor"],
        "session_start_s": results["session_start_s"],
        "warnings": len(results["warnings"]),
    }


def _triad_columns(section: Mapping[str, Any]) -> Row:
    diagnosis, prediction = section["diagnosis"], section["prediction"] or {}
    row: Row = {
        "verdict": diagnosis["verdict"],
        "missing": " + ".join(diagnosis["names"]),
        "group": " ".join(diagnosis["group"]),
        "says": diagnosis["says"],
        "model": " + ".join(section["model"]),
    }
    for key in ("n_poses", "chi2", "dof", "p_value", "residual_rms", "loo_rms", "sd_widened_by"):
        row[key] = section[key]
    row["prediction_sd_median"] = prediction.get("sd_median")
    row["prediction_sd_worst"] = prediction.get("sd_worst")
    noise = section["sd_parts"]["noise"]
    for key in PARAMETERS:
        for i, axis in enumerate(AXES):
            row[f"{key}_{axis}"] = section["parameters"][key][i]
            row[f"{key}_{axis}_sd"] = section["sd"][key][i]
            row[f"{key}_{axis}_noise_sd"] = noise[key][i]
    return row | dict(_sizes(section))


def _sizes(section: Mapping[str, Any]) -> Iterator[tuple[str, float | None]]:
    """Largest parameter of every effect that is in the model or named as missing, with its sd."""
    named = {item["name"]: item for item in section["diagnosis"]["ranking"]
             if item["name"] in section["diagnosis"]["names"]}
    fitted = {name: {"size": item["values"], "sd": item["sd"]}
              for name, item in section["effects"].items()}
    for name, item in (named | fitted).items():
        stated = [(abs(size), size, sd) for size, sd in zip(item["size"], item["sd"], strict=True)
                  if size is not None]
        if stated:
            _, size, sd = max(stated, key=lambda one: one[0])
            yield f"{SIZE}_{name}", size
            yield f"{SIZE_SD}_{name}", sd

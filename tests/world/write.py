"""Writes a session as a user would have it: config.yaml, logs as CSV, clips. Never the truth."""

import gzip
import io
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tests.world.bench import Run
from tests.world.designs import RPM
from tests.world.imu import G_STANDARD, FloatArray, Triad
from tests.world.scene import Scene
from tests.world.session import PoseLog, RunLog, Session

if TYPE_CHECKING:  # the film needs an encoder, which sessions without clips do not
    from tests.world.film import FilmTruth, Recorder

RECORD_SPEEDS_RPM = np.array([50 / 3, 100 / 3, 45.0, 78.0])
COUNT_COLUMNS = ("acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z")


@dataclass(frozen=True, eq=False)
class Written:
    """Where a session was written, and the truth of its clips by the name of the plate setting."""

    folder: Path
    config: Path
    films: "Mapping[str, FilmTruth]"


@dataclass(frozen=True)
class Camera:
    """How the clips are taken; ``model`` are the terms that the configuration states for them."""

    fps: float = 15.0
    seconds: float = 60.0
    scene: Scene = field(default_factory=Scene)
    recorder: "Recorder | None" = None
    seed: int = 0
    model: tuple[str, ...] = ()


def write_session(
    folder: Path,
    session: Session,
    *,
    film: bool | Camera = True,
    compressed: bool = False,
) -> Written:
    """Write ``session`` into ``folder``, which is made where it is missing.

    With a camera (True for an ordinary one) every plate setting gets a clip; without, config.yaml
    states its rate and sd, which is much faster. ``compressed`` writes .csv.gz.
    """
    camera = Camera() if film is True else film or None
    suffix = ".csv.gz" if compressed else ".csv"
    for where, logs in pose_files(session):
        target = folder / f"{where}{suffix}"
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(_packed(table_text(logs)) if compressed else table_text(logs).encode())
    films = _film(folder, session, camera) if camera else {}
    config = folder / "config.yaml"
    config.write_text(config_text(session, camera, suffix), encoding="utf-8")
    return Written(folder, config, films)


def pose_files(session: Session) -> list[tuple[str, PoseLog]]:
    """Every pose with its path, without the suffix; poses at rest are numbered through."""
    files, still = [], 0
    for log in session.runs:
        for i, pose in enumerate(log.poses):
            if log.run.in_accelerometer_section:
                still += 1
                files.append((f"accelerometer/pose_{still:02d}", pose))
            else:
                files.append((f"gyroscope/{log.run.name}/pose_{i + 1:02d}", pose))
    return files


def table_text(pose: PoseLog) -> str:
    """One pose as CSV: time in seconds, counts, then the other columns."""
    columns = [pose.time_s, *pose.accelerometer.T, *pose.gyroscope.T, *pose.columns.values()]
    decimals = [_decimals(values) for values in pose.columns.values()]
    row = ",".join(["%.4f", *["%d"] * 6, *(f"%.{d}f" for d in decimals)]) + "\n"
    header = ",".join(["time_s", *COUNT_COLUMNS, *pose.columns]) + "\n"
    table = np.column_stack(columns)
    return header + row * len(table) % tuple(table.ravel().tolist())


def _decimals(values: FloatArray) -> int:
    """Fewest decimals that lose nothing of what was logged."""
    return next(d for d in range(10) if np.allclose(values, np.round(values, d), atol=1e-9))


def _packed(text: str) -> bytes:
    """Gzip without file name and time, so that the same text gives the same bytes."""
    buffer = io.BytesIO()
    with gzip.GzipFile(filename="", mode="wb", fileobj=buffer, mtime=0) as stream:
        stream.write(text.encode())
    return buffer.getvalue()


def _film(folder: Path, session: Session, camera: Camera) -> "dict[str, FilmTruth]":
    from tests.world.film import film

    (folder / "video").mkdir(parents=True, exist_ok=True)
    return {
        log.run.name: film(
            folder / "video" / f"{log.run.name}.mp4",
            log.run.motion,
            camera.scene,
            fps=camera.fps,
            seconds=camera.seconds,
            recorder=camera.recorder,
            seed=camera.seed + i,
        )
        for i, log in enumerate(session.runs)
        if log.run.motion is not None
    }


def config_text(session: Session, camera: Camera | None, suffix: str = ".csv") -> str:
    """The config.yaml of a session, with a comment wherever a unit or a choice needs one."""
    design = session.design
    acc, gyr = design.sensor.accelerometer, design.sensor.gyroscope
    filmed = [log for log in session.runs if log.run.motion is not None]
    on_plate = [log for log in filmed if not log.run.in_accelerometer_section]
    still = [log for log in session.runs if log.run.in_accelerometer_section]
    lines = [
        *_comment(session, camera),
        f"title: {design.title}",
        "",
        "sensor:",
        f"  name: {design.sensor.name}",
        f"  accelerometer: {{{_full_scale(acc, 'accelerometer')}, {_converter(acc)}}}",
        f"  gyroscope: {{{_full_scale(gyr, 'gyroscope')}, {_converter(gyr)}}}",
        "",
        "site:  # the reference of the accelerometers, and Earth's rotation for the gyroscopes",
        f"  latitude_deg: {design.site.latitude_deg}",
        f"  gravity_m_s2: {design.site.gravity_m_s2}",
        "",
    ]
    if filmed:
        lines += ["rate:  # the reference of the gyroscopes, one entry per setting of the plate"]
        for log in filmed:
            lines += _rate_lines(session, log, camera)
        lines += [""]
    if still:
        lines += [
            "accelerometer:  # poses at rest: the length of the specific force is gravity",
            f"  poses: accelerometer/pose_*{suffix}",
            "  model: [bias, scale, misalignment]",
        ]
    elif on_plate:
        lines += ["accelerometer:  # the plate leans: gravity goes round in every pose", "  runs:"]
        lines += _run_lines(on_plate, suffix)
    if on_plate:
        lines += [
            "",
            "gyroscope:  # poses on the turning plate: the length of the rate is the plate's",
            "  runs:",
        ]
        lines += _run_lines(on_plate, suffix)
        at_rest = any(log.run.motion is None for log in still)
        if at_rest and session.design.rests_count_for_gyroscope:
            lines += [f"    - {{poses: accelerometer/pose_*{suffix}, rate: stopped}}"]
        lines += ["  model: [bias, scale, misalignment]"]
    return "\n".join(lines) + "\n"


def _run_lines(on_plate: list[RunLog], suffix: str) -> list[str]:
    """The runs on the plate."""
    return [f"    - {{poses: gyroscope/{log.run.name}/pose_*{suffix}, rate: {log.run.name}}}"
            for log in on_plate]


def _comment(session: Session, camera: Camera | None) -> list[str]:
    """What was done, for whoever opens the file first."""
    lines = ["# What was recorded:"]
    for log in session.runs:
        run = log.run
        lines += [f"#   {len(run.directions)} poses of {run.seconds:g} s {_where(run)}"]
    if camera:
        lines += [f"#   a clip of {camera.seconds:g} s, {camera.fps:g} frames/s, of every setting"]
    rate = f"{session.design.sample_rate_hz:g} Hz"
    return [
        *lines,
        f"# Logs: time in seconds, raw counts of the sensor at {rate}, temperature.",
        "",
    ]


def _where(run: Run) -> str:
    if run.motion is None:
        return "at rest"
    way = "counter-clockwise" if run.motion.rate_rad_s > 0 else "clockwise"
    return f"on the plate turning {way} ({run.name})"


def _rate_lines(session: Session, log: RunLog, camera: Camera | None) -> list[str]:
    name, stated = log.run.name, session.rates[log.run.name]
    if camera is None:
        return [
            f"  {name}: {{rate_rad_s: {abs(stated.rate_rad_s):.9g}, "
            f"sd_rad_s: {stated.sd_rad_s:.3g}}}"
        ]
    rpm = abs(stated.rate_rad_s) / RPM
    marked = RECORD_SPEEDS_RPM[np.argmin(np.abs(RECORD_SPEEDS_RPM - rpm))]
    return [
        f"  {name}:",
        f"    video: video/{name}.mp4",
        f"    nominal_rpm: {marked:.5g}  # as marked on the record player: a check, not a value",
        "    timebase: {source: container, ppm: 50}  # how far the camera's clock may be off",
        *([f"    model: [{', '.join(camera.model)}]  # what the angle of the plate follows"]
          if camera.model else []),
    ]


def _full_scale(triad: Triad, kind: str) -> str:
    if kind == "gyroscope":
        return f"full_scale_deg_s: {np.rad2deg(triad.full_scale):.6g}"
    in_g = triad.full_scale / G_STANDARD
    if abs(in_g - round(in_g)) < 1e-9:
        return f"full_scale_g: {in_g:.6g}"
    return f"full_scale_m_s2: {triad.full_scale:.6g}"


def _converter(triad: Triad) -> str:
    encoding = "offset-binary" if triad.offset_binary else "twos-complement"
    return f"bits: {triad.bits}, encoding: {encoding}"

"""A calibration written for other programs, one function for each.

An exporter takes a :class:`pipeline.results.read.Stored` and returns the files it writes and notes
on what they cannot store: no exporter drops an effect or a triad without a note.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

from calib.poses.imu_log import TRIADS
from pipeline.export.ardupilot import to_ardupilot
from pipeline.export.certificate import to_certificate
from pipeline.export.firmware import to_fusion, to_inav, to_px4
from pipeline.export.parts import Export
from pipeline.export.plain import to_csv, to_imu_tk, to_json, to_residuals
from pipeline.export.programs.syntax import to_arduino, to_matlab, to_python
from pipeline.export.robotics import to_kalibr, to_ros
from pipeline.results.read import Stored

Exporter = Callable[[Stored], Export]


def inertial_only(program: str, exporter: Exporter) -> Exporter:
    """An exporter whose file has no place for triads beyond accelerometer and gyroscope."""

    def export(stored: Stored) -> Export:
        kept = tuple(triad for triad in stored.triads if triad.name in TRIADS)
        written = exporter(replace(stored, triads=kept))
        lost = tuple(f"{program} is written without the {triad.name}; csv, json and the programs "
                     f"hold it." for triad in stored.triads if triad.name not in TRIADS)
        return replace(written, loses=(*written.loses, *lost))

    return export


#: Format -> exporter; :data:`pipeline.export.formats.FORMATS` describes each in a line.
EXPORTERS: Mapping[str, Exporter] = {
    "json": to_json,
    "csv": to_csv,
    "imu_tk": inertial_only("imu_tk", to_imu_tk),
    "kalibr": inertial_only("Kalibr", to_kalibr),
    "ros": inertial_only("ROS imu_calib", to_ros),
    "arduino": to_arduino,
    "python": to_python,
    "matlab": to_matlab,
    "fusion": inertial_only("Fusion's inertial model", to_fusion),
    "px4": inertial_only("PX4", to_px4),
    "inav": inertial_only("INAV", to_inav),
    "ardupilot": inertial_only("ArduPilot", to_ardupilot),
    "residuals": to_residuals,
    "certificate": to_certificate,
}

"""A calibration written for other programs, one function for each.

An exporter takes a :class:`pipeline.results.read.Stored` and returns the files it writes and notes
on what they cannot store: no exporter drops an effect without a note.
"""

from collections.abc import Callable, Mapping

from pipeline.export.ardupilot import to_ardupilot
from pipeline.export.certificate import to_certificate
from pipeline.export.firmware import to_fusion, to_inav, to_px4
from pipeline.export.parts import Export
from pipeline.export.plain import to_csv, to_imu_tk, to_json
from pipeline.export.programs.write import to_arduino, to_matlab, to_python
from pipeline.export.residuals import to_residuals
from pipeline.export.robotics import to_kalibr, to_ros
from pipeline.results.read import Stored

#: Format -> exporter; :data:`pipeline.export.formats.FORMATS` describes each in a line.
EXPORTERS: Mapping[str, Callable[[Stored], Export]] = {
    "json": to_json,
    "csv": to_csv,
    "imu_tk": to_imu_tk,
    "kalibr": to_kalibr,
    "ros": to_ros,
    "arduino": to_arduino,
    "python": to_python,
    "matlab": to_matlab,
    "fusion": to_fusion,
    "px4": to_px4,
    "inav": to_inav,
    "ardupilot": to_ardupilot,
    "residuals": to_residuals,
    "certificate": to_certificate,
}

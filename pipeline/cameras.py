"""The clocks of the user's cameras, as ``pipeline clock`` measured them: one file for each user.

A camera's quartz is off by a constant 10 to 100 ppm, which is a scale error of every rate that it
films. Measured once it is known to a few ppm, and remains so but for the temperature and the age of
the quartz.
"""

import json
import math
import os
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import date
from pathlib import Path

from pipeline.errors import UnreadableInput
from pipeline.files import write_whole

FOLDER = "turntable-imu-calibration"
FORMAT = 1  #: number of the file's format: its index
LARGEST_PPM = 1e4  #: fact: no quartz and no ceramic resonator is off by one per cent

AGEING_PPM_PER_YEAR = 3.0
"""Fact: data sheets of AT-cut crystals state 3 to 5 ppm for the first year and less after it."""

DAYS_PER_YEAR = 365.25  #: definition


@dataclass(frozen=True)
class CameraClock:
    """The clock that stamps the clips of a camera.

    Attributes
    ----------
    name : str
    fast_ppm : float
        It runs fast by so much: its seconds are too short.
    sd_ppm : float
        Of that, all parts together, on the day of the measurement.
    parts_ppm : mapping of str to float
        The parts of the sd by name.
    measured : date
    how : str
        What the computer's clock was known by.
    """

    name: str
    fast_ppm: float
    sd_ppm: float
    parts_ppm: Mapping[str, float]
    measured: date
    how: str

    def sd_on(self, day: date) -> float:
        """Sd in ppm on another day: a quartz ages."""
        years = abs((day - self.measured).days) / DAYS_PER_YEAR
        return math.hypot(self.sd_ppm, AGEING_PPM_PER_YEAR * years)


def cameras_file() -> Path:
    """Path of the file of the clocks."""
    return user_folder() / "cameras.json"


def user_folder() -> Path:
    """The user's folder of this program, by the custom of the system; it need not be there."""
    stated = os.environ.get("XDG_CONFIG_HOME")
    if stated:
        return Path(stated) / FOLDER
    if sys.platform == "win32":
        return Path(os.environ.get("APPDATA", Path.home())) / FOLDER
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / FOLDER
    return Path.home() / ".config" / FOLDER


def known_cameras() -> Mapping[str, CameraClock]:
    """All clocks by the camera's name; none where the file is not there yet.

    Raises
    ------
    UnreadableInput
        The file is damaged.
    """
    path = cameras_file()
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return {}
    except (OSError, UnicodeDecodeError) as error:
        raise UnreadableInput(f"{path}: cannot be read ({error}). Check that it is a text file, "
                              f"and that you may read it.") from error
    try:
        entries = json.loads(text)["cameras"]
        return {name: _clock(name, entry) for name, entry in entries.items()}
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise UnreadableInput(
            f"{path}: the clocks of the cameras cannot be read ({type(error).__name__}: {error}). "
            f"Repair the file, or delete it and measure the clocks again (pipeline clock)."
        ) from error


def keep_camera(clock: CameraClock) -> Path:
    """Store a clock with the others, in place of an older one of its name.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    UnreadableInput, UnwritableOutput
        The file is damaged, or cannot be written.
    """
    path = cameras_file()
    clocks = {**known_cameras(), clock.name: clock}
    entries = {name: {key: value for key, value in asdict(kept).items() if key != "name"}
               for name, kept in sorted(clocks.items())}
    write_whole(path, json.dumps({"format": FORMAT, "cameras": entries}, indent=1, default=str,
                                 ensure_ascii=False) + "\n")
    return path


def _clock(name: str, entry: Mapping[str, object]) -> CameraClock:
    parts = entry["parts_ppm"]
    if not isinstance(parts, dict):
        raise ValueError("parts_ppm is no mapping")
    clock = CameraClock(
        name=name,
        fast_ppm=_finite(entry["fast_ppm"]),
        sd_ppm=_finite(entry["sd_ppm"]),
        parts_ppm={part: _finite(sd) for part, sd in parts.items()},
        measured=date.fromisoformat(str(entry["measured"])),
        how=str(entry["how"]),
    )
    if not 0 < clock.sd_ppm < LARGEST_PPM or abs(clock.fast_ppm) > LARGEST_PPM:
        raise ValueError(f"{name}: {clock.fast_ppm:g} ± {clock.sd_ppm:g} ppm is no clock's error")
    return clock


def _finite(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"found {value!r}, a number is expected")
    return float(value)

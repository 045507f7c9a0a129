"""The meaning of a column's name: the quantity, the axis, the unit."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

from calib.poses.imu_log import AXES
from pipeline.logs.columns import SECONDS_PER

Quantity = Literal["time", "counter", "acc", "gyr", "temperature", "samples", "sd", "label", ""]

UNITS = {
    "m_s2": ("m/s2", "mps2", "m_s2", "ms2", "м/с2"),
    "g": ("g", "gee"),
    "mg": ("mg",),
    "ug": ("ug", "µg", "μg"),
    "cm_s2": ("cm/s2", "gal", "gals"),
    "mm_s2": ("mm/s2",),
    "rad_s": ("rad/s", "radians/s", "rad/sec", "rads", "rad_s", "rps", "рад/с"),
    "deg_s": ("deg/s", "°/s", "º/s", "dps", "deg_s", "degrees/s",
              "°/sec", "deg/sec", "grad/s", "град/с", "°/с"),
    "mdeg_s": ("mdps", "mdeg/s"),
    "ddeg_s": ("ddps", "ddeg/s", "0.1deg/s", "0.1dps", "0.1°/s"),
    "cdeg_s": ("cdps", "cdeg/s", "0.01deg/s", "0.01dps", "0.01°/s"),
    "deg_h": ("deg/h", "°/h", "º/h", "deg/hr", "deg/hour", "dph"),
    "mrad_s": ("mrad/s", "mrad_s"),
    "rpm": ("rpm", "r/min", "rev/min", "u/min", "tr/min"),
    "uT": ("ut", "µt", "μt", "nt", "mt", "gauss", "mgauss", "mga"),
    "V": ("v", "volt", "volts"),
    "mV": ("mv", "millivolt", "millivolts"),
    "s": ("s", "sec", "secs", "second", "seconds", "с", "秒"),
    "ms": ("ms", "msec", "millis", "milliseconds", "мс", "毫秒"),
    "us": ("us", "µs", "μs", "usec", "micros", "microseconds"),
    "ns": ("ns", "nsec", "nsecs", "nanosec", "nanoseconds"),
    "min": ("min", "minutes"),
    "d": ("days", "day"),
    "counts": ("counts", "count", "lsb", "raw"),
    "fahrenheit": ("°f", "℉", "ºf", "f", "degf", "fahrenheit"),
    "kelvin": ("kelvin", "°k"),
    "celsius": ("°c", "℃", "ºc", "°", "º", "c", "degc", "celsius"),
}
TEMPERATURE_UNITS = {"celsius", "kelvin", "fahrenheit"}
FORCE_UNITS = {"m_s2", "g", "mg", "ug", "cm_s2", "mm_s2"}
RATE_UNITS = {"rad_s", "deg_s", "mdeg_s", "mrad_s", "ddeg_s", "cdeg_s", "deg_h", "rpm"}
RAISED = str.maketrans("⁻¹²", "-12")
SIGNS = re.compile(r"[\s^()*·⋅]|\.(?=[a-z])")  #: between the parts of a unit; of text
INVERSE = re.compile(r"s-([12])$")
_UNIT = {spelling: unit for unit, spellings in UNITS.items() for spelling in spellings}

TIME = {"time", "timestamp", "t", "ts", "stamp", "timeus", "timems", "sampleus", "millis", "micros",
        "ms", "us", "ns", "datetime", "date", "clock", "elapsed", "seconds", "utc", "epoch", "sec",
        "secs", "second", "msec", "usec", "minutes", "zeit", "uhrzeit", "temps", "tiempo", "tempo",
        "zeitstempel", "hora", "heure", "tick", "ticks", "tstamp", "tijd", "czas", "время",
        "时间", "時間", "時刻", "tow"}
CLOCK_WORDS = TIME & _UNIT.keys()
COUNTER = {"packetcounter", "counter", "samplecounter", "n", "sample", "nsamples",
           "loopiteration", "index", "seq", "nr", "no", "row", "zeile", "id", "idx", "lfdnr", "#"}
ACC = {"acc", "accel", "acceleration", "accelerometer", "accl", "a", "ac", "accx", "accsmooth",
       "accadc", "specificforce", "force", "beschleunigung", "beschl", "accélération",
       "aceleración", "aceleracion", "accelerazione", "acel", "acceler", "aceleracao", "acele",
       "versnelling", "przyspieszenie", "ускорение", "уск", "加速度"}
GYR = {"gyr", "gyro", "gyroscope", "g", "gy", "w", "ω", "omega", "gyroadc", "gyrounfilt", "rate",
       "rot", "rotation", "angular", "angvel", "rotationrate", "angularvelocity", "angrate",
       "gyroskop", "drehrate", "winkelgeschwindigkeit", "giroscopio", "gyromètre", "giro",
       "gir", "gyros", "vitesseangulaire", "velocidadangular", "angulaire", "angolare",
       "hoeksnelheid", "гироскоп", "угловая", "угл", "角速度", "陀螺仪", "陀螺"}
TEMPERATURE = {"temp", "temperature", "tmp", "tempc", "degc", "temperatur", "temperatura",
               "température", "tempcelsius", "dietemp", "t_c", "温度",
               "температура"}
#: Words that mark a column as another quantity, whatever the other words are.
OTHER = {"mag", "user", "schwerkraft", "zwaartekracht", "гравитация", "重力", "quat", "quaternion",
         "q", "qua", "quaternions", "dcm", "euler", "roll", "pitch", "yaw", "setpoint", "pos",
         "position", "axisp", "axisi", "axisd", "axisf", "debug", "motor", "bias",
         "covariance", "orientation", "orient", "heading", "angle", "angles", "attitude", "winkel",
         "角度", "磁场", "磁場"}
OTHER_BEGINNINGS = ("magn", "магн", "grav", "graw")
"""Beginnings of the words for a magnetic field and for computed gravity in several languages."""
FIELD_LETTERS = {"b", "h", "m"}  #: names of a magnetic field beside an axis: ``Bx``, ``mX``
LINEAR = ("linea", "linéa", "liniow", "линейн")
"""Beginnings of the word for an acceleration of which gravity was removed, in several languages."""
WITH_GRAVITY = {"including", "incl", "with"}  #: before "gravity": a browser's, phyphox's
TURNS = {"roll": "x", "pitch": "y", "yaw": "z", "alpha": "x", "beta": "y", "gamma": "z",
         "p": "x", "q": "y", "r": "z"}
"""Axes of a rate in aerospace and in a browser, if the name or its unit shows that it is a rate:
browsers give alpha about x, and the specification follows them (W3C, Device Orientation, #43)."""
RATES = {"rate", "rotationrate", "rotation", "speed", "velocity", "vel", "gyro"}
SD = {"sd", "std", "stddev", "sigma", "σ", "sem", "err", "error", "uncertainty", "fehler",
      "unsicherheit", "stdabw", "erreur", "incertitude", "errore", "incertezza", "chyba",
      "nejistota", "błąd", "niepewność", "погрешность"}
ENDS_OF_TIME = ("time", "timestamp", "millis", "micros")  #: ``sensortime``, ``boot_millis``
CLOCK_OF_UNIT = re.compile(r"(us|ms|ns|µs)_?(time|timestamp|stamp|clock|ticks?)")
"""A time preceded by its unit: ``ustime``, ``ms_stamp``."""
QUATERNION = re.compile(r"q(uat(ernion)?)?[ _.\[]?[wxyz0-3ijkr]\]?", re.IGNORECASE)
"""Elements of a quaternion, not axes of a sensor: ``qx``, ``q0``, ``quat_w``."""
RATIO = re.compile(r"[_ ](mm|m|m?rad|m?deg)(?:ian|ree)?s?[_ ]?(?:per|p|[_ ]|(?=s\^?-?2$))[_ ]?"
                   r"s(?:ec(?:ond)?)?(?:[_ ]?\^?-?(2))?$")
"""A unit in words at the end of a name: ``_m_s2``, ``_ms2``, ``_radps``, ``_deg_per_sec``."""
POSITION = re.compile(r":\d+$")  #: a column of an array, whose name has no meaning
WORD = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-ZА-Я]?[a-zà-ÿа-яё]+|[A-ZА-Я]+|[一-鿿]+|[α-ω]+|\d+|[°µ]")


@dataclass(frozen=True)
class Words:
    """The meaning of a name; empty fields are not stated.

    ``axis`` is 0, 1, 2 or None; ``stem`` is the name without its axis. ``is_other``: it states
    another quantity than an inertial reading, as a magnetic field or computed gravity.
    """

    quantity: Quantity = ""
    axis: int | None = None
    unit: str = ""
    stem: str = ""
    gravity_free: bool = False
    is_other: bool = False


@lru_cache(maxsize=4096)  # each file of a session has the same names, and is read again and again
def read_name(name: str) -> Words:
    """Read the name of a column.

    >>> read_name("Acceleration x (m/s^2)")
    Words(quantity='acc', axis=0, unit='m_s2', stem='acceleration', gravity_free=False, \
is_other=False)
    """
    if POSITION.search(name) or QUATERNION.fullmatch(name.strip()):
        return Words(stem="quaternion" if "q" in name.lower() else "")
    if front := CLOCK_OF_UNIT.fullmatch(name.strip().lower()):
        return Words("time", None, _UNIT[front.group(1)], front.group(2))
    text, unit = _split_unit(name.strip().lstrip("#").strip())
    text, axis = _split_index(text)
    words = [word.lower() for word in WORD.findall(text)]
    if "gravity" in words and WITH_GRAVITY & {*words}:
        words = [word for word in words if word not in WITH_GRAVITY | {"gravity"}]
    turns = [word for word in words if word in TURNS]
    if len(turns) == 1 and (RATES & {*words} or (unit in RATE_UNITS and words == turns)):
        words = ["gyro", *(word for word in words if word not in TURNS), TURNS[turns[0]]]
    if words[:1] == ["g"] and words[1:] in (["fx"], ["fy"], ["fz"]):  # "gFx": force in g
        words, unit = ["acc", words[1][1]], "g"
    spread = [words.pop()] if len(words) > 1 and words[-1] in SD else []
    if not unit and len(words) > 1 and words[-1] in _UNIT:
        unit = _UNIT[words.pop()]
    if axis is None:
        words, axis = _split_axis(words)
    unit = unit or next((_UNIT[word] for word in words if word in CLOCK_WORDS), "")
    unit = "min" if words == ["min"] else unit
    words += spread
    stem = "".join(words)
    quantity = _quantity(words, stem, axis) or _quantity_by_unit(words, axis, unit, text != name)
    if quantity == "time" and unit in TEMPERATURE_UNITS:  # "T (degC)"
        quantity = "temperature"
    is_other = _is_other(words) or unit == "uT" or (
        axis is not None and not quantity and stem.rstrip("0123456789") in FIELD_LETTERS)
    return Words(quantity, axis, unit, stem, _gravity_free(text, words), is_other)


def spelled_unit(text: str) -> str:
    """The unit that a text spells, empty if it spells none.

    >>> {spelled_unit(text) for text in ("m s⁻²", "m·s^-2", "ms-2", "m/s/s", "m/(s^2)")}
    {'m_s2'}
    """
    text = SIGNS.sub("", text.lower().translate(RAISED)).replace("/s/s", "/s2")
    return _UNIT.get(INVERSE.sub(lambda power: "/s" + power[1].strip("1"), text), "")


def axes_among(names: Iterable[str]) -> list[str]:
    """The names of axes of an accelerometer or a gyroscope."""
    return [name for name in names if (word := read_name(name)).axis is not None
            and word.quantity in ("acc", "gyr")]


def whole_triples(
    words: Sequence[Words], quantity: str
) -> list[tuple[bool, tuple[int, int, int]]]:
    """Positions of all x, y, z of one quantity whose names differ only in the axis.

    Each is preceded by a flag: whether gravity is removed from their readings.
    """
    stems: dict[tuple[str, bool], dict[int, int]] = {}
    for i, word in enumerate(words):
        if word.quantity == quantity and word.axis is not None:
            stems.setdefault((word.stem, word.gravity_free), {})[word.axis] = i
    return [(free, (axes[0], axes[1], axes[2])) for (_, free), axes in stems.items()
            if len(axes) == len(AXES)]


def _split_unit(name: str) -> tuple[str, str]:
    """``Accel X (g)`` -> ``("Accel X", "g")``."""
    for match in re.finditer(r"[(\[]((?:[^()\[\]]|\([^()]*\))*)[)\]]", name):
        if spelled := spelled_unit(match.group(1)):
            return f"{name[: match.start()].strip()} {name[match.end() :].strip()}".strip(), spelled
    if name.lower().endswith("_degc"):
        return name[: -len("_degc")], "celsius"
    if (ratio := RATIO.search(name.lower())) and (
            unit := _UNIT.get(f"{ratio.group(1)}/s{ratio.group(2) or ''}")):
        return name[: ratio.start()], unit
    return name, ""


def _split_index(name: str) -> tuple[str, int | None]:
    """``gyroADC[0]`` -> ``("gyroADC", 0)``."""
    match = re.search(r"\[([012])\]$", name)
    return (name[: match.start()], int(match.group(1))) if match else (name, None)


def _split_axis(words: list[str]) -> tuple[list[str], int | None]:
    """Words without the axis, and the axis: a word of one letter, or the end of a short word."""
    for i in (-1, 0):
        if words and words[i] in AXES:
            axis = AXES.index(words[i])
            return (words[:-1] if i else words[1:]), axis
    number = words[-1:] if len(words) > 1 and words[-1].isdecimal() else []  # "ax1" of many boards
    *front, last = words[:len(words) - len(number)] or [" "]
    if last[-1] in "xyz" and last[:-1] in ACC | GYR | FIELD_LETTERS | {"mag", "t"}:
        return [*front, last[:-1], *number], "xyz".index(last[-1])
    inside = [i for i, word in enumerate(words) if word in AXES]
    if len(inside) == 1:  # "Gyro_X_CAL"
        return words[: inside[0]] + words[inside[0] + 1 :], AXES.index(words[inside[0]])
    return words, None


def _quantity(words: list[str], stem: str, axis: int | None) -> Quantity:
    known = {*words, stem}
    if known & SD and axis is not None:
        return "sd"
    if stem in ("samples", "count"):
        return "samples"
    if _is_other(words):
        return ""
    if axis is not None:
        letters = {"a", "g", "w"} - {stem}
        longest = {quantity: max(map(len, known & names - letters), default=0)
                   for quantity, names in (("acc", ACC), ("gyr", GYR))}
        if any(longest.values()):  # "Shimmer_AC7B_Gyro_X" is no "AC"
            return "acc" if longest["acc"] >= longest["gyr"] else "gyr"
        ends = {*words[:1], *words[-1:]}  # EuRoC's a_RS_S_x and w_RS_S_x, adxl_ax and itg_gx
        return "acc" if "a" in ends else "gyr" if ends & {"g", "w"} else ""
    if known & TEMPERATURE:
        return "temperature"
    if stem in COUNTER:
        return "counter"
    if known & TIME or stem == "min" or stem.endswith(ENDS_OF_TIME):
        return "time"
    return ""


def _quantity_by_unit(words: list[str], axis: int | None, unit: str, in_brackets: bool) -> Quantity:
    """The quantity of a name by its unit alone: "x-axis (deg/s)", "X_Value (s)"."""
    if _is_other(words) or not in_brackets:
        return ""
    if unit in SECONDS_PER:
        return "time"
    if unit == "celsius" and axis is None:
        return "temperature"
    if axis is None:
        return ""
    return "acc" if unit in FORCE_UNITS else "gyr" if unit in RATE_UNITS else ""


def _is_other(words: list[str]) -> bool:
    """Whether a word states another quantity than an inertial one."""
    return bool(OTHER & {*words, "".join(words)}) or any(
        word.startswith(OTHER_BEGINNINGS) for word in words)


def _gravity_free(text: str, words: list[str]) -> bool:
    """Whether gravity is removed: "linear" in phone apps, but not in ROS; Xsens' "free"."""
    return not {"user", "free"}.isdisjoint(words) or (
        "_" not in text and any(word.startswith(LINEAR) for word in words))

"""Rules on keys of a configuration that exclude or require each other.

Each rule reads one mapping of the file as it was written and yields ``(key, what is wrong)``. Rules
see every file, even one with wrong values, so that all mistakes are listed at once.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from calib.effects.catalogue import EFFECTS
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.config.types import STOPPED
from pipeline.config.yaml_text import PathTo, path_text
from pipeline.logs.columns import (
    TIME,
    missing_columns,
    our_name,
    parts_missing,
)

Values = Mapping[str, Any]
Problems = Iterator[tuple[str, str]]


def _one_of(section: Values, *keys: str) -> Problems:
    """Require exactly one of ``keys``."""
    present = [key for key in keys if key in section]
    if len(present) > 1:
        yield present[1], f"'{present[0]}' is given as well; give one of the two"
    elif not present:
        yield keys[0], f"{' or '.join(keys)} is missing; add one of them"


def whole_file(section: Values) -> Problems:
    """A file must ask for something, and each section needs those it depends on."""
    tasks = ("rate", *TRIAD_KINDS, "installation", "record")
    if not any(task in section for task in tasks):
        yield "", f"nothing to do: none of {', '.join(tasks)} is given"
    triads = [triad for triad in TRIAD_KINDS if triad in section]
    if triads and "sensor" not in section:
        yield "sensor", ("is missing; name a preset as in `sensor: xsens-mti`, or give the data "
                   "sheet's full scale, bits and encoding")
    sheet = section.get("sensor")
    for triad in triads:
        if isinstance(sheet, dict) and triad not in sheet:
            yield "sensor", f"the data sheet of the {triad} is missing; add sensor.{triad}"
    if "accelerometer" in section and "site" not in section:
        yield "site", ("is missing: the accelerometer is fitted to gravity. Give latitude_deg "
                   "and height_m, or gravity_m_s2")
    if "installation" in section and "accelerometer" not in section:
        yield "installation", ("needs the accelerometer's calibration; add the accelerometer "
                               "section with its poses")


def triad_sheet(section: Values) -> Problems:
    """Require a data sheet in counts, or the unit of logs in physical units."""
    scales = [key for key in section if key.startswith(("full_scale", "counts_per"))]
    converter = [key for key in section if key in ("bits", "encoding")]
    if "unit" in section:
        for key in scales + converter:
            yield key, ("only for logs in counts; `unit` says that these logs are in physical "
                        "units. Delete one of the two")
        return
    if not scales:
        yield "full_scale", ("is missing; add full_scale_g or full_scale_m_s2 of an accelerometer, "
                             "full_scale_deg_s of a gyroscope, or counts_per_g and "
                             "counts_per_deg_s, or `unit` for logs in physical units")
    if len(scales) > 1:
        yield scales[1], f"'{scales[0]}' is given as well; give one of the two"
    if scales and scales[0].startswith("counts_per") and not converter:
        return
    for key in ("bits", "encoding"):
        if key not in section:
            yield key, "is missing; the sensor's data sheet states it"


def site(section: Values) -> Problems:
    """Require gravity."""
    if not any(key.startswith(("gravity", "latitude")) for key in section):
        yield "gravity_m_s2", "is missing, and latitude_deg too: one of them must state gravity"


def rate(section: Values) -> Problems:
    """Require a rate that is filmed or known, not both."""
    stated = [key for key in section if key.startswith(("rate", "sd_"))]
    if "video" not in section and not stated:
        yield "video", "video is missing; or give rate_rad_s and sd_rad_s, measured elsewhere"
    if "video" in section:
        for key in stated:
            yield key, "'video' is given as well; give one of the two"


def rates(section: Values) -> Problems:
    """Refuse the reserved name."""
    if STOPPED in section:
        yield STOPPED, (f"'{STOPPED}' is the rate of a plate that does not turn and needs no "
                        "entry; choose another name")


def timebase(section: Values) -> Problems:
    """Require the value of a constant frame rate, none for time stamps; a whole known clock."""
    if "camera" in section:
        for key in ("source", "fps", "ppm"):
            if key in section:
                yield key, "not with `camera`: the clock of that camera was measured. Delete one"
        return
    if section.get("source") == "constant" and "fps" not in section:
        yield "fps", "is missing: `source: constant` takes the time from the frame rate"
    if section.get("source", "container") == "container" and "fps" in section:
        yield "fps", "only for `source: constant`; the container states its time stamps itself"


def poses(section: Values) -> Problems:
    """Require files, long logs or a table of means, and columns that fit them."""
    yield from _one_of(section, "log", "files", "means")
    if "log" in section and "find" not in section:
        yield "find", "is missing: write `find: still` to search the log for static intervals"
    if "files" in section and "find" in section:
        yield "find", "only for `log`; each of `files` is one pose"
    if "means" in section and "find" in section:
        yield "find", "only for `log`; each row of `means` is one pose"
    yield from still(section)
    yield from picked_columns(section)


def accelerometer(section: Values) -> Problems:
    """Require poses at rest, runs on a leaning plate, or both."""
    if "poses" not in section and "runs" not in section:
        yield "poses", ("is missing; name the logs of the poses at rest, or under `runs` those "
                        "taken on the turning plate, which must then lean")
    if "exclude" in section and "poses" not in section:
        yield "exclude", "belongs beside `poses`, or into one of `runs`"


def still(section: Values) -> Problems:
    """Require a search for settings of the search."""
    if "still" in section and "find" not in section:
        yield "still", "only with `find: still`, whose search it overrules"


def picked_columns(section: Values) -> Problems:
    """Require lists of names, one per log, or mappings from our names to the file's."""
    rows = section.get("columns")
    if "time_unit" in section and "sample_rate_hz" in section:
        yield "time_unit", "only for logs with a column of times; delete time_unit or " \
                           "sample_rate_hz"
    if not rows or not isinstance(rows, list | dict):
        return
    rows = rows if isinstance(rows, list) and not isinstance(rows[0], str) else [rows]
    for names in rows:
        if isinstance(names, dict):
            # Columns that are not picked may still be there under our names.
            yield from (("columns", lacks) for lacks in parts_missing(names))
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            continue  # a mapping, or the type itself is wrong and reported as such
        ours = [our_name(name)[0] for name in names]
        if lacks := missing_columns(ours):
            yield "columns", lacks
        if TIME not in ours and "sample_rate_hz" not in section and "log" in section:
            yield "columns", f"{TIME} is missing; name it, or give sample_rate_hz beside columns"
        if TIME in ours and "sample_rate_hz" in section:
            yield "sample_rate_hz", f"the columns have {TIME}; delete one of the two"


def model(section: Values) -> Problems:
    """Refuse an effect given twice, or together with one that contains it."""
    names = section.get("model")
    if isinstance(names, list):
        for i, name in enumerate(names):
            if name in names[:i]:
                yield "model", f"'{name}' is given twice. Delete one of the two"
            whole = [other for other in EFFECTS if other in names and
                     name in EFFECTS[other].contains]
            if whole:
                yield "model", (f"'{name}' is part of '{whole[0]}', which the model has too. "
                                f"Delete one of the two")


def user_defined(section: Values) -> Problems:
    """Require an expression or a function, not both."""
    yield from _one_of(section, "expression", "python")


def record(section: Values) -> Problems:
    """Require a pattern where, and only where, lines are read by one."""
    if section.get("device") == "lines" and "pattern" not in section:
        yield "pattern", ("is missing; describe a line, as in "
                          "'{time_ms},{acc_x},{acc_y},{acc_z},{gyr_x},{gyr_y},{gyr_z}'")
    if "pattern" in section and section.get("device") != "lines":
        yield "pattern", "only for `device: lines`; the other devices are known. Delete it"


#: Paths at which each rule applies; ``*`` is any key or list position.
RULES: tuple[tuple[PathTo, Callable[[Values], Problems]], ...] = (
    ((), whole_file),
    (("sensor", "*"), triad_sheet),
    (("site",), site),
    (("rate",), rates),
    (("rate", "*"), rate),
    (("rate", "*"), model),
    (("rate", "*", "timebase"), timebase),
    (("accelerometer",), accelerometer),
    (("*",), model),
    (("*", "poses"), poses),
    (("*", "runs", "*", "poses"), poses),
    (("installation",), picked_columns),
    (("installation",), still),
    (("effects", "*"), user_defined),
    (("record",), record),
)


def broken_rules(values: Values) -> Iterator[tuple[PathTo, str]]:
    """Paths and messages of the rules that the values of a file break."""
    for pattern, rule in RULES:
        for path, section in _matches(values, pattern, ()):
            for key, problem in rule(section):
                yield ((*path, key) if key else path), problem


def empty_keys(value: object, path: PathTo = ()) -> Iterator[tuple[PathTo, str]]:
    """Keys with nothing after the colon."""
    if value is None:
        empty = (f"nothing stands after '{name}:'; give a value, or delete the key"
                 if (name := path_text(path[-1:])) else "an entry of the list is empty")
        yield path, empty
    items = value.items() if isinstance(value, dict) else enumerate(
        value if isinstance(value, list) else ())
    for key, child in items:
        if child is None and isinstance(value, dict) and str(key).isdecimal():
            yield (*path, key), (f"'{key}' stands alone after a comma; a number has a decimal "
                                 f"point, as in 59.91")
        else:
            yield from empty_keys(child, (*path, key))


def _matches(value: Any, pattern: PathTo, path: PathTo) -> Iterator[tuple[PathTo, Values]]:
    """Every mapping whose path matches ``pattern``."""
    if not pattern:
        if isinstance(value, dict):
            yield path, value
        return
    children = value if isinstance(value, dict) else dict(enumerate(value)) if isinstance(
        value, list) else {}
    for key, child in children.items():
        if pattern[0] in ("*", key):
            yield from _matches(child, pattern[1:], (*path, key))

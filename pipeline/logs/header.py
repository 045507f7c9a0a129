"""Names of a header as ours: exactly, or by the words in them where these leave no doubt."""

from collections.abc import Sequence

from calib.poses.imu_log import TEMPERATURE
from pipeline.logs.columns import (
    ACCELEROMETER,
    GYROSCOPE,
    SECONDS_PER,
    TIME,
    missing_columns,
    our_name,
)
from pipeline.logs.header_words import Words, read_name, whole_triples

TRIPLES = {"acc": ACCELEROMETER, "gyr": GYROSCOPE}
Named = tuple[str, float]  #: our name, and the factor to our unit


def our_names(header: Sequence[str]) -> list[Named]:
    """Our name and the factor of every column; a name that says nothing stays as it is.

    >>> our_names(["millis", "AcX", "AcY", "AcZ"])[0]
    ('time_s', 0.001)
    """
    exact = [our_name(name) for name in header]
    names = [name for name, _ in exact]
    whole = missing_columns(names) is None
    if whole and TIME in names:
        return exact
    words = [read_name(name) for name in header]
    read = list(exact)
    if TIME not in names:
        _name_the_time(read, words)
    if not whole:
        for quantity, ours in TRIPLES.items():
            _name_a_triad(read, words, quantity, ours)
    _name_the_temperature(read, words)
    return read if missing_columns([name for name, _ in read]) is None else exact


def _name_the_time(read: list[Named], words: Sequence[Words]) -> None:
    """The one column of times; of several the one whose name states a unit."""
    times = [i for i, word in enumerate(words) if word.quantity == "time"]
    if len(times) > 1:
        times = [i for i in times if words[i].unit in SECONDS_PER]
    if len(times) == 1:
        unit = words[times[0]].unit
        read[times[0]] = (TIME, next((factor for name, factor in SECONDS_PER.items()
                                      if name == unit), 1.0))


def _name_a_triad(
    read: list[Named], words: Sequence[Words], quantity: str, ours: Sequence[str]
) -> None:
    """The one triple of a quantity whose names differ in nothing but the axis."""
    whole = [places for free, places in whole_triples(words, quantity) if not free]
    if len(whole) == 1 and not {name for name, _ in read} & set(ours):
        for name, i in zip(ours, whole[0], strict=True):
            read[i] = (name, 1.0)


def _name_the_temperature(read: list[Named], words: Sequence[Words]) -> None:
    """The one temperature that is stated in °C."""
    warmth = [i for i, word in enumerate(words)
              if word.quantity == "temperature" and word.unit == "celsius"]
    if len(warmth) == 1 and all(name != TEMPERATURE for name, _ in read):
        read[warmth[0]] = (TEMPERATURE, 1.0)

"""Our names for those of a header: exactly, or by their words if these are unambiguous."""

from collections.abc import Sequence

from calib.poses.imu_log import TEMPERATURE
from pipeline.errors import UnreadableInput
from pipeline.logs.columns import (
    ACCELEROMETER,
    GYROSCOPE,
    READINGS,
    SECONDS_PER,
    SKIP,
    TIME,
    ColumnNames,
    Renamed,
    bare,
    missing_columns,
    our_name,
)
from pipeline.logs.header_words import Words, read_name, whole_triples
from pipeline.text.names import nearest_names

LONGEST_SHOWN, CELLS_SHOWN = 30, 12  #: letters and cells of a wrong header in a message
MISSING_TRIAD = ("The header needs time_s and acc_x, acc_y, acc_z or gyr_x, gyr_y, gyr_z or both; "
                 "rename the columns, give their names by `columns` in the configuration, or let "
                 "`pipeline import` guess them")
TRIPLES = {"acc": ACCELEROMETER, "gyr": GYROSCOPE}
Named = tuple[str, float]  #: our name, and the factor to our unit


def our_names(header: Sequence[str]) -> list[Named]:
    """Our name and the factor of every column; an unknown name is unchanged.

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
    """Name the single column of times; of several, the only one whose name states a unit."""
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
    """Name the single triple of a quantity whose names differ only in the axis."""
    whole = [places for free, places in whole_triples(words, quantity) if not free]
    if len(whole) == 1 and not {name for name, _ in read} & set(ours):
        for name, i in zip(ours, whole[0], strict=True):
            read[i] = (name, 1.0)


def _name_the_temperature(read: list[Named], words: Sequence[Words]) -> None:
    """Name the single temperature in °C."""
    warmth = [i for i, word in enumerate(words)
              if word.quantity == "temperature" and word.unit == "celsius"]
    if len(warmth) == 1 and all(name != TEMPERATURE for name, _ in read):
        read[warmth[0]] = (TEMPERATURE, 1.0)


def named_columns(
    where: str, header: Sequence[str] | None, width: int, columns: ColumnNames | None,
    ends_open: bool = False,
) -> list[tuple[str, float]]:
    """Our name and the factor of every column of a log.

    Parameters
    ----------
    where : str
        File, and line if it has lines, for messages.
    header : sequence of str or None
        Names of the columns in the file.
    width : int
        Number of columns.
    columns : sequence of str or Renamed or None
        Names of the columns in the configuration.
    ends_open : bool
        Whether rows end with a delimiter, so that the last column is empty.

    Raises
    ------
    UnreadableInput
        The columns hold no complete triad, or have no names, or too few or too many.
    """
    if isinstance(columns, Renamed):
        renamed = columns.apply(header or ())
        if renamed is None:
            raise _not_among(where, header or (), columns)
        names = [_renamed(name, theirs, columns)
                 for name, theirs in zip(renamed, header or (), strict=True)]
    elif columns is not None:
        names = [our_name(name) for name in columns]
    elif header is None:
        raise _headerless(where, width)
    else:
        names = our_names(header)
        if missing_columns([name for name, _ in names]) is not None:
            raise wrong_header(where, header)
    if ends_open and width == len(names) + 1:
        names.append((SKIP, 1.0))
    listed = ", ".join(name for name, _ in names)
    if width != len(names):
        raise UnreadableInput(
            f"{where}: {width} values found, {len(names)} expected ({listed}). Name every column "
            f"of the file, '{SKIP}' for those not to be read, or delete the damaged line."
        )
    if lacks := missing_columns([name for name, _ in names]):
        raise UnreadableInput(f"{where}: {lacks} (columns: {listed}). {MISSING_TRIAD}.")
    return names


def _renamed(name: str, theirs: str, columns: Renamed) -> tuple[str, float]:
    """A renamed column with its factor; the time of a known program keeps that program's factor."""
    known, factor = our_name(theirs)
    if name == known == TIME:
        return name, factor
    return our_name(name) if name in columns.ours else (name, 1.0)


def _headerless(where: str, n: int) -> UnreadableInput:
    """The error for rows without a header, whose names the user must state."""
    usual = ", ".join([*[TIME] * (n % 3 == 1), *ACCELEROMETER, *GYROSCOPE * (n > 5)])
    return UnreadableInput(
        f"{where}: {n} column{'' if n == 1 else 's'} of numbers without a header. Name them "
        f"beside the file in the configuration, for example `columns: [{usual}]`; '{SKIP}' names "
        f"a column not to be read. `pipeline import` guesses the names from the numbers."
    )


def wrong_header(where: str, cells: Sequence[str]) -> UnreadableInput:
    """The error for a header that names no triad, with the nearest right names."""
    names = [our_name(cell)[0] for cell in cells]
    near = [f"'{name}' for '{cell}'" for cell in cells if our_name(cell)[0] not in READINGS
            for name in nearest_names(cell, READINGS)]
    meant = f" (did you mean {', '.join(near)}?)" if near else ""
    return UnreadableInput(
        f"{where}: found {_shown(cells)}: {missing_columns(names)}{meant}. {MISSING_TRIAD}."
    )


def _not_among(where: str, header: Sequence[str], columns: Renamed) -> UnreadableInput:
    """The error for a configuration that selects a column that the file does not have."""
    names = [bare(name) for name in header]
    absent = [theirs for _, theirs in columns.pairs if bare(theirs) not in names]
    return UnreadableInput(
        f"{where}: `columns` picks '{absent[0] if absent else ''}', but the "
        f"columns are {_shown(names) or 'not named'}. Write the name as it stands in the file."
    )


def _shown(cells: Sequence[str]) -> str:
    shown = ", ".join(cell[:LONGEST_SHOWN] for cell in cells[:CELLS_SHOWN])
    return f"{shown}{', ...' if len(cells) > CELLS_SHOWN else ''}"

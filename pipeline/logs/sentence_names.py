"""Names of the numbers in lines of text: the words before them, or the cells of a header.

Examples are ``I (1312) IMU: acc=0.01,-0.02,0.98 gyr=1.2,0.3,-0.5``, ``Gyro X: 0.1 Y: 0.2 Z: 0.3``,
keys of YAML under those of the lines above, and ``"Accel X";"14:05:00.1";0.98``.
"""

import re
from collections import Counter
from collections.abc import Sequence
from itertools import groupby

from calib.poses.imu_log import AXES
from pipeline.logs.dialect import DELIMITERS
from pipeline.logs.header_words import read_name, spelled_unit

#: Repetitions are possessive (``++``), or the search of a long line would take minutes.
NUMBER = r"[-+]?(?:\d++(?:\.\d*+)?|\.\d++)(?:[eE][-+]?\d++)?"
DATE = (r"(?:\d{4}-\d{1,2}-\d{1,2}|\d{1,2}[./]\d{1,2}[./]\d{4}|\d{4}/\d{1,2}/\d{1,2}"
        r"|\d{2}-\d{2}(?= \d{2}:\d{2}:\d{2}))")
CLOCK = r"\d{1,2}:\d{2}:\d{2}(?:[.:]\d++|,\d{3}(?![\d.,]))?(?: ?[AP]M\b|Z\b|[-+]\d{2}:?\d{2}\b)?"
#: No number is a part of a word, a byte or a clock, nor a fraction before a unit: ``1/16 °/s``.
SLOT = re.compile(
    r"(?<![\w.^])(?<![A-Za-z]/)(?<![\s;,(]\d/)(?!0x)"
    r"(?!\d/\d++ ?[°A-Za-z])(?!(?<=\d:)(?<!\d\d\d\d:)\d\d(?!\d))"
    rf"(?:(?:{DATE}[ T])?{CLOCK}(?!\w|:\d)|{DATE}(?![\w.])|{NUMBER})")
COLOURS = re.compile(r"\x1b\[[0-9;]*m")  #: colour codes of a terminal
IN_BRACKETS = re.compile(r"[\[({][^\])}]*+[\])}]")
LABELS = re.compile(r"\{\w+=[^}]*\}")  #: what a database tells one series from others by
AROUND = " \t:=<>()[]{}/\"',;|#$%*&-"
BEHIND = {"[": "]", "(": ")"}
APART = str.maketrans(':{"<>', "     ")  #: signs between the words of a name: of keys inside keys
PAIR = re.compile(r"(?<!\S)[^\s=]+=\w[^\s=]*(?!\S)")  #: a word with its key, as ``board=esp32``
QUOTED = re.compile(r',"|",')  #: what is between a name, a number in quotes and its unit in cells
MARK = "\0"  #: placeholder of a number


def without_colours(line: str) -> str:
    """``line`` without the colour codes of a terminal."""
    return COLOURS.sub("", line) if "\x1b" in line else line


def names_of_header(form: str, above: str) -> list[str]:
    """Names from the cells of the line above, with the units that follow the numbers; empty if it
    has other cells than the line of this form."""
    sign = max(DELIMITERS, key=form.count)
    whole = IN_BRACKETS.sub(lambda vector: vector[0].replace(sign, " "), form)
    cells, names = whole.split(sign), [name.strip(' "') for name in above.split(sign)]
    if len(cells) != len(names) or len(cells) < 2 or SLOT.search(LABELS.sub("", above)):
        return []
    named: list[str] = []
    for cell, name in zip(cells, names, strict=True):
        count = cell.count(MARK)
        unit = cell.rpartition(MARK)[2].strip(AROUND) if count else ""
        title = f"{name} ({unit})" if spelled_unit(unit) else name
        named += [title, f"{title} sd"] if count == 2 and "±" in cell else _spread(title, count)
    return named


def names_of_sample(sample: Sequence[str]) -> list[str]:
    """Names of all numbers in the lines of a sample; empty where nothing names a number.

    A line without numbers is the title of those that are indented more, and of single axes.
    """
    named: list[str] = []
    titles: list[tuple[int, str]] = []
    for line in map(without_colours, sample):
        indent = len(line) - len(line.lstrip())
        if not SLOT.search(line):
            titles = [(depth, title) for depth, title in titles if depth < indent]
            titles.append((indent, line.strip(AROUND)))
            continue
        for name in _names_of_line(line):
            lone = name.lower() in AXES
            above = [title for depth, title in titles if depth < indent or lone]
            if lone and not above and named and named[-1][-1:].lower() in AXES:
                above = [named[-1][:-1].strip()]
            named.append(" ".join([*above, name]) if name else "")
    return named


def numbered(names: Sequence[str]) -> list[str]:
    """The names without commas, repeated ones with a number, and positions for empty ones."""
    seen: Counter[str] = Counter()
    every = []
    for place, name in enumerate(names, 1):
        seen[name] += 1
        again = f" {seen[name]}" if seen[name] > 1 else ""
        every.append(f"{name}{again}".replace(",", " ").replace('"', "") if name else str(place))
    return every


def _names_of_line(line: str) -> list[str]:
    """Names from the words before the numbers; two more numbers without words are further axes.

    A single axis belongs to the name before it, a unit after the last of three numbers to all.
    """
    labels: list[str] = []
    units: dict[int, str] = {}
    *parts, last = SLOT.split(QUOTED.sub(" ", line))
    names = [" ".join(PAIR.sub("", re.split(r"[,;|]", part)[-1]).translate(APART).strip(
        AROUND).split()) for part in parts]
    in_front = _units_in_front(names)
    for part, words in zip(parts, names, strict=True):
        words += "".join(BEHIND[sign] for sign in BEHIND if words.count(sign) > words.count(
            BEHIND[sign]))
        behind, _, others = words.partition(" ")
        if labels:
            is_unit = spelled_unit(behind.strip(AROUND)) and behind not in in_front
            behind = behind if is_unit else ""
            unit = behind or next(iter(re.split(r"[,;|]", part)), "").strip(AROUND)
            if spelled_unit(unit.strip(AROUND)):
                units[len(labels) - 1] = unit.strip(AROUND)
                words = others if behind else words
        if words.lower() in AXES and labels and labels[-1][-1:].lower() in AXES:
            words = f"{labels[-1][:-1]}{words}"
        labels.append(words if any(map(str.isalpha, words)) else "")
    if spelled_unit(behind := last.strip(AROUND)) or spelled_unit(
            behind := re.split(r"[,;|\s]", last.strip())[0].strip(AROUND)):
        units[len(labels) - 1] = behind
    named: list[str] = []
    for label, unit in _by_groups(labels, units):
        named.append(f"{label} ({unit})" if unit and label else label)
    return named


def _units_in_front(names: Sequence[str]) -> set[str]:
    """Words of units that begin the names of axes, in place of what is behind the number before:
    ``t=0.1 raw ax=7 raw ay=-3``."""
    leads: dict[str, list[int]] = {}
    for i, name in enumerate(names):
        unit, _, axis = name.partition(" ")
        if spelled_unit(unit) and read_name(axis).axis is not None:
            leads.setdefault(unit, []).append(i)
    before = {unit: names[at[0] - 1] if at[0] else "" for unit, at in leads.items() if at[1:]}
    return {unit for unit, name in before.items()
            if unit in name.split() or read_name(name).axis is None}


def _by_groups(labels: Sequence[str], units: dict[int, str]) -> list[tuple[str, str]]:
    """The name and the unit of each number: those of a triad share both."""
    groups: list[list[str]] = []
    for is_named, run in groupby(labels, key=bool):
        several = list(run)
        if is_named or not groups:
            groups += [[label] for label in several]
        else:
            groups[-1] += several
    every: list[tuple[str, str]] = []
    for group in groups:
        unit = units.get(len(every) + len(group) - 1, "")
        every += [(name, units.get(len(every) + i, unit if len(group) == len(AXES) else ""))
                  for i, name in enumerate(_spread(group[0], len(group)))]
    ends = [i for i, (name, unit) in enumerate(every) if unit and read_name(name).axis == 2]
    for i in ends:  # "X: 0.1 Y: 0.2 Z: 0.3 m/s^2"
        three = [read_name(name).axis for name, _ in every[max(i - 2, 0) : i + 1]]
        if three == [0, 1, 2] and not any(unit for _, unit in every[i - 2 : i]):
            every[i - 2 : i] = [(name, every[i][1]) for name, _ in every[i - 2 : i]]
    return every


def _spread(name: str, count: int) -> list[str]:
    """Names of several numbers with one name: with the axes for a triad, else none of them."""
    if count == len(AXES):
        return [f"{name} {axis}" if name else "" for axis in AXES]
    words = read_name(name)
    known = count == 1 or words.axis is not None or words.quantity == "time"
    return [name if known else "", *[""] * (count - 1)][:count]

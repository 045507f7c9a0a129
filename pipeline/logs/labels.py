"""Rows of a table from lines with text around numbers, as sketches print them.

The formats are a name before every number (``ax:12 ay:-7``, ``aX = 1.2, aY = 0.3``, also with a few
lines per sample), the clock of a serial monitor before an arrow (``12:00:00.010 -> 1,2,3``), rows
whose first cell names their kind, documents of YAML, sentences of NMEA, and those of
:mod:`pipeline.logs.sentences`. Rows keep their line numbers in the file.
"""

import re
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import islice, pairwise

from calib.poses.imu_log import AXES
from pipeline.logs.dialect import delimiter_of
from pipeline.logs.header_words import spelled_unit
from pipeline.logs.sentences import DAY, FEWEST, LEAST_SHARE, NUMBER, SLOT, rows_of_sentences

LOOKED_AT = 60  #: number of last lines, after the words of a sketch at its start
LABEL = re.compile(rf"(?<![\w:])([A-Za-zµ°][\w ./\[\]()²^°-]{{0,60}}?)"
                   rf"['\"]?\s*[:=]\s*['\"]?({NUMBER})(?![\w:.])")
ARROW = re.compile(r"\s*\[?(\d{1,2}:\d{2}:\d{2}[.:,]\d+)\]?\s*->\s*(.*)")
NUMBERED = re.compile(rf"\s*({NUMBER}):\s+(?={NUMBER})")
STAMPED = re.compile(rf"\s*\[?{DAY}")  #: a line that begins with a time
TITLE = re.compile(r"^\s*+([A-Za-z ]++):\s*(?=[A-Za-z]\s*[:=])")  #: "Acceleration: X:0.1, Y: 0.2"
TAG = re.compile(rf"\s*[A-Za-z][\w/ ]*[:>]\s+(?={NUMBER}[\s,;]+{NUMBER}[\s,;]+{NUMBER})")
"""A word before a row that is not the name of a number: ``a/g: 1 2 3``."""
SENTENCE = re.compile(r"\s*+\$(\w++),(.*)\*[0-9A-Fa-f]{2}\s*+")  #: a sentence of NMEA 0183
KIND = re.compile(r"([A-Z][A-Z0-9_]*)\s*,")  #: a first cell that names the kind of a row
END_OF_DOCUMENT = "---"
KEY = re.compile(r"( *)([A-Za-z_]\w*):\s*(.*?)\s*")  #: a line of YAML
MOST_LINES = 12  #: largest number of lines of a sample: values of three sensors and their times
PLOTTED = re.compile(rf">([A-Za-z]\w*):(?:(\d+):)?({NUMBER})\S*\s*")
"""A value for Teleplot: ``>ax:0.1``, or ``>ax:1714557600000:0.1`` with its time in ms."""


def unlabelled_lines(lines: list[str]) -> list[str]:
    """``lines`` as rows of numbers under a header, or unchanged if no format fits.

    The header replaces the line before the first row or, without such a line, the first row.
    """
    lines = _without_colons(lines)
    shown = list(islice((line for line in reversed(lines) if line.strip()), LOOKED_AT))[::-1]
    if _share(shown, lambda line: ARROW.fullmatch(line) is not None) >= LEAST_SHARE:
        return _clocked_rows(lines, [match[2] for line in shown
                                      if (match := ARROW.fullmatch(line))])
    if _share(shown, lambda line: TAG.match(line) is not None) >= LEAST_SHARE:
        return [TAG.sub("", line) for line in lines]
    if _share(shown, lambda line: PLOTTED.fullmatch(line) is not None) >= LEAST_SHARE:
        first = (match[1] for line in shown if (match := PLOTTED.fullmatch(line)))
        return unlabelled_lines(_named_values(lines, next(first)))
    if (documents := _documents(lines)) is not None:
        return documents
    if (rows := _of_one_kind(lines, shown)) is not None:
        return rows
    cycle = _cycle(shown)
    numbers = sum(len(SLOT.findall(line)) for line in shown)
    if sum(map(len, cycle)) >= FEWEST:
        without = numbers - sum(len(labels_of(line)) for line in shown)
        if without <= 0 or (without <= len(shown) and not any(map(STAMPED.match, shown))):
            return _table_rows(lines, cycle)
        # A name of a triad, or numbers followed by units: "Acc[mg]: 12 -3 1001".
        samples = [sample.replace("#", " ") for sample in _samples(lines, cycle)]
        return (rows_of_sentences(samples, [*filter(None, samples)][-LOOKED_AT:])
                or _table_rows(lines, cycle))
    tags = Counter(match[1] for line in shown if (match := SENTENCE.fullmatch(line)))
    if tags and (tag := tags.most_common(1)[0])[1] >= len(shown) / 2:
        return [match[2] if (match := SENTENCE.fullmatch(line)) and match[1] == tag[0]
                else f"# {line}" for line in lines]
    return rows_of_sentences(lines, shown) or lines


def _without_colons(lines: list[str]) -> list[str]:
    """Lines without the colon after a leading number, if nearly all have one: ``1200: 1 2 3``."""
    fits = _share(lines, lambda line: NUMBERED.match(line) is not None) >= LEAST_SHARE
    return [NUMBERED.sub(r"\1 ", line) for line in lines] if fits else lines


def labels_of(line: str) -> tuple[str, ...]:
    """The names before the numbers of a line; a single axis belongs to the name before it, and a
    unit after the last of three numbers to all of them.

    >>> labels_of("Gyro X: 0.1 Y: 0.2 Z: 0.3")
    ('Gyro X', 'Gyro Y', 'Gyro Z')
    """
    names: list[str] = []
    end = 0
    text = TITLE.sub(r"\1 ", line)
    for match in LABEL.finditer(text):
        label, end = match[1], match.end()
        words = label.split()
        if label.lower() in AXES and names and names[-1].split()[-1].lower() in AXES:
            words = [*names[-1].split()[:-1], label]
        names.append(" ".join(words))
    if len(names) == len(AXES) and spelled_unit(text[end:]):
        names = [f"{name} ({text[end:].strip()})" for name in names]
    return tuple(names)


def _named_values(lines: Sequence[str], first: str) -> list[str]:
    """Values for Teleplot with their names, and with the time of the one named ``first``."""
    return [line if (match := PLOTTED.fullmatch(line)) is None else
            f"{f't_ms={match[2]}, ' if match[2] and match[1] == first else ''}{match[1]}={match[3]}"
            for line in lines]


def _share(lines: Sequence[str], fits: Callable[[str], bool]) -> float:
    return sum(map(fits, lines)) / len(lines) if lines else 0.0


def _clocked_rows(lines: Sequence[str], shown: Sequence[str]) -> list[str]:
    """Lines with the clock of the monitor as their first cell, or as their first label."""
    if all(len(labels_of(line)) >= FEWEST for line in shown):
        return unlabelled_lines([
            f"t={_day_seconds(match[1])}, {match[2]}" if (match := ARROW.fullmatch(line)) else line
            for line in lines])
    inner = unlabelled_lines([match[2] if (match := ARROW.fullmatch(line)) else line
                            for line in lines])
    return [f"{match[1]}{delimiter_of(row) or ' '}{row}"
            if (match := ARROW.fullmatch(line)) and row else row
            for line, row in zip(lines, inner, strict=True)]


def _day_seconds(clock: str) -> str:
    """``12:00:00.010`` as seconds of the day."""
    hours, minutes, seconds = re.split(r":", clock.replace(",", "."), maxsplit=2)
    return f"{int(hours) * 3600 + int(minutes) * 60 + float(seconds.replace(':', '.')):.6f}"


def _documents(lines: list[str]) -> list[str] | None:
    """Rows from documents of YAML, as ``ros2 topic echo`` prints them; None if there are none.

    A row replaces the line that ends its document. The keys with a number are its columns, each
    preceded by the keys above it.
    """
    ends = [i for i, line in enumerate(lines) if line.strip() == END_OF_DOCUMENT]
    if len(ends) < FEWEST:
        return None
    rows = [f"# {line}" for line in lines]
    begin, names = 0, None
    for end in ends:
        above: list[tuple[int, str]] = []
        cells: dict[str, str] = {}
        for match in map(KEY.fullmatch, lines[begin:end]):
            if match is None:
                continue
            depth = len(match[1])
            above = [*((d, key) for d, key in above if d < depth), (depth, match[2])]
            if re.fullmatch(NUMBER, match[3]):
                cells[" ".join(key for _, key in above)] = match[3]
        names = names or [*cells]
        if [*cells] == names and names:
            rows[end] = ",".join(cells.values())
        begin = end + 1
    if names:
        rows[0] = ",".join(names)
    return rows if names else None


def _of_one_kind(lines: Sequence[str], shown: Sequence[str]) -> list[str] | None:
    """Lines of the most frequent kind, if the first cell names the kind of each line.

    Kinds of other widths are left out, such as an autopilot's messages among its sensors' rows;
    None if there is only one kind, or a kind of the same width may be another sensor.
    """
    kinds = Counter((match[1], line.count(",")) for line in shown
                    if (match := KIND.match(line)) is not None)
    widths = {width for _, width in kinds}
    if len(kinds) < 2 or kinds.total() < len(shown) or len(widths) < len(kinds):
        return None
    main, width = kinds.most_common(1)[0][0]
    rows = [line if line.count(",") == width and line.startswith(main) else "" for line in lines]
    for i, line in enumerate(lines):  # "FMT, 163, 58, IMU, QBff, TimeUS, GyrX, ..."
        cells = [cell.strip() for cell in line.split(",")]
        if main in cells[1:] and len(cells) > width and not any(
                SLOT.fullmatch(cell) for cell in cells[-width:]):
            rows[i] = ",".join([cells[0], *cells[-width:]])
            break
    return rows


def _cycle(shown: Sequence[str]) -> tuple[tuple[str, ...], ...]:
    """The labels of the one or few lines of a sample; empty if they do not recur."""
    labels = [labels_of(line) for line in shown if not _is_of_words(line)]
    cycle = tuple(dict.fromkeys(labels[: 2 * MOST_LINES]))
    if not labels or len(cycle) > MOST_LINES or () in cycle:
        return ()
    follows = {one: cycle[(i + 1) % len(cycle)] for i, one in enumerate(cycle)}
    kept = sum(follows.get(one) == other for one, other in pairwise(labels))
    return cycle if kept >= LEAST_SHARE * (len(labels) - 1) else ()


def _is_of_words(line: str) -> bool:
    """Whether a line has no label and no triad of numbers: text between the lines of a sample."""
    return not labels_of(line) and len(SLOT.findall(line)) < FEWEST


def _samples(lines: Sequence[str], cycle: tuple[tuple[str, ...], ...]) -> list[str]:
    """The lines of each sample joined in place of its last line; the other lines empty."""
    rows = []
    sample: list[str] = []
    for line in lines:
        labels = labels_of(line)
        if labels != cycle[len(sample)] and not _is_of_words(line):
            sample = []
        if labels == cycle[len(sample)]:
            sample.append(line)
        whole = len(sample) == len(cycle)
        rows.append(" ".join(sample) if whole else "")
        sample = [] if whole else sample
    return rows


def _table_rows(lines: Sequence[str], cycle: tuple[tuple[str, ...], ...]) -> list[str]:
    """A row in place of the last line of each sample, comments in place of all other lines."""
    rows = [",".join(number for _, number in LABEL.findall(sample)) if sample else f"# {line}"
            for line, sample in zip(lines, _samples(lines, cycle), strict=True)]
    first = next((i for i, row in enumerate(rows) if not row.startswith("#")), None)
    if first is None:
        return list(lines)
    rows[max(first - 1, 0)] = ",".join(name for names in cycle for name in names)
    return rows

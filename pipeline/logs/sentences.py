"""Rows of numbers from lines with text around them, as sketches, consoles and databases print them.

The form of a line is its text with a mark in place of each number and time. The lines of a log have
one form, or a few that recur in one order: a line for each sensor or axis, a document of YAML. The
lines of a sample are joined into one row. Rows keep their line numbers in the file.
"""

import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from itertools import chain, islice, pairwise

import numpy as np

from pipeline.logs.columns import TIME
from pipeline.logs.dialect import (
    LOST,
    SHOWN,
    Dialect,
    delimiter_of,
    dialect_of,
    local_date_seconds,
    seconds_of,
)
from pipeline.logs.head import FEWEST_NUMBERS
from pipeline.logs.header_words import axes_among, spelled_unit
from pipeline.logs.sentence_names import (
    MARK,
    SLOT,
    names_of_header,
    names_of_sample,
    numbered,
    without_colours,
)

MOST_LINES = 100  #: largest number of lines of a sample
LEAST_SHARE = 0.9
"""Least share of the lines with one form, or in one order; least correlation of one value of a
sample with that of the next, which is 1 less the noise over gravity. A judgement."""
LINES_OF_SENSORS = 4  #: fact: of a sample: two triads, a magnetic field and a temperature
MOST_VALUES = 17  #: largest number of values of a sample with a line for each: four triads and more
PADDING = re.compile(rf"(?<=[\[({{:=]) | (?=[\])}}])|(?<={MARK}) (?!{MARK})|(?<!{MARK}) (?={MARK})")
"""Blanks around numbers and inside brackets, which the width of a number changes."""
LETTERS = re.compile(r"0x[0-9A-Fa-f]+|[^\W\d_]+")  #: a byte is a word too, as a state or a number
LIST = re.compile(r"(?<![\d.])-?[\d.]++(?:[|]-?[\d.]++){4,}")  #: samples of one channel in one cell
LABELLED = re.compile(r"[^\W\d_][^\d:=]*[:=]\s*[-+]?\.?\d[^\s:=]*")
"""A number behind a word, in one cell: ``a/g: -12``."""
COMMA = re.compile(r"(\d),(\d)")  #: a decimal comma
NO_COMMA = re.compile(r"\d\.\d|\d,-?\d+,")  #: a decimal point, or commas between numbers


def rows_of_lines(lines: list[str]) -> list[str]:
    """``lines`` as rows of numbers under a header, or unchanged if they are a table already.

    The header replaces the line before the first row.
    """
    shown = [*islice((line for line in reversed(lines) if line.strip()), SHOWN)][::-1]
    if shown and delimiter_of(shown[-1]) in (";", "\t", None) and not any(
            map(NO_COMMA.search, shown)) and any(map(COMMA.search, shown)):
        decimal = [COMMA.sub(r"\1.\2", line) for line in shown]
    else:
        decimal = shown
    if not shown or not _hide_numbers(decimal):
        return lines
    if decimal is not shown:
        lines, shown = [COMMA.sub(r"\1.\2", line) for line in lines], decimal
    for form in (form_of, _loose_form):
        cycle = _cycle([*map(form, shown)])
        if cycle == [MARK]:  # a number a line
            cycle *= _period([float(line) for line in shown if form(line) == MARK])
        if sum(one.count(MARK) for one in cycle) >= FEWEST_NUMBERS:
            return _rows(lines, cycle, form)
    return lines


def _period(numbers: Sequence[float]) -> int:
    """The number of values of a sample, written one after another: the first lag at which they
    recur; 1 if there is none."""
    values = np.array(numbers)
    lags = range(1, min(MOST_VALUES, len(values) // 2))
    apart = [np.mean((values[lag:] - values[:-lag]) ** 2) / 2 for lag in lags]
    return next((lag for lag, variance in zip(lags, apart, strict=True)
                 if variance < (1 - LEAST_SHARE) * values.var()), 1)


def form_of(line: str) -> str:
    """The line with marks in place of its numbers, and no more than single blanks."""
    return PADDING.sub("", " ".join(SLOT.sub(MARK, without_colours(line)).split()))


def _loose_form(line: str) -> str:
    """The form of a line whose words change, such as a state or a level."""
    return LETTERS.sub("a", form_of(line))


def _cycle(forms: Sequence[str]) -> list[str]:
    """The forms of the lines of a sample, in order; empty if they do not recur.

    Forms of one or two lines are messages between the samples.
    """
    counts = Counter(forms)
    form, count = counts.most_common(1)[0]
    if count >= LEAST_SHARE * len(forms):
        return [form]
    recurring = [form for form in forms if counts[form] > 2] or [*forms]
    for period in range(1, min(MOST_LINES, len(recurring) // 2) + 1):
        alike = sum(map(str.__eq__, recurring, recurring[period:]))
        if alike >= LEAST_SHARE * (len(recurring) - period):
            cycle = recurring[:period]
            separators = [i for i, form in enumerate(cycle) if _separates(form, cycle)]
            begin = separators[-1] + 1 if separators else 0
            return cycle[begin:] + cycle[:begin]
    return []


def _separates(form: str, cycle: Sequence[str]) -> bool:
    """Whether a line has no words and no numbers, or the stamp before each line alone: ``~ ->``."""
    is_stamp = not form.endswith(MARK) and all(one.startswith(form) for one in cycle)
    return not LETTERS.search(form) and (MARK not in form or is_stamp)


def _rows(lines: Sequence[str], cycle: Sequence[str], form: Callable[[str], str]) -> list[str]:
    """A row in place of the last line of each sample, comments in place of all other lines."""
    cycle = _from_first(lines, cycle, form)
    forms = [*map(form, lines)]
    samples = dict(_samples(lines, forms, cycle))
    if not samples:
        return [*lines]
    first, example = next(iter(samples.items()))
    marks = [LOST if one not in cycle and one.count(MARK) >= FEWEST_NUMBERS else "#"
             for one in forms]
    rows = [f"{marks[at]} {line}" if at > first else f"# {line}" if any(map(str.isdigit, line))
            else "" for at, line in enumerate(lines)]  # words above are no header of the rows
    for at, sample in samples.items():
        rows[at] = ",".join(slot.replace(",", ".") for line in sample
                            for slot in SLOT.findall(without_colours(line)))
    names = names_of_sample(example)
    begin = next((i for i, line in enumerate(lines) if line in example), first)
    above = next((line for line in reversed(lines[:begin]) if line.strip()), "")
    if len(cycle) == 1 or not any(map(LETTERS.search, cycle)):
        titles = [names_of_header(form_of(line), above) for line in example]
        names = [*chain(*titles)] if all(titles) else names
    shown = [cells.split(",") for cells in islice((rows[at] for at in samples), SHOWN)]
    for end in (0, -1):  # a stamp without a name, before the readings or behind them
        if names and not names[end]:
            stamps = [cells[end] for cells in shown]
            names[end] = TIME if ":" in stamps[0] else "t" if _grow(stamps) else ""
    if any(names):  # positions alone would be a row of numbers
        rows[first - 1] = ",".join(numbered(names))
    return rows


def _from_first(
    lines: Sequence[str], cycle: Sequence[str], form: Callable[[str], str]
) -> list[str]:
    """The cycle from the form with which the first complete sample of the file begins."""
    if any(_separates(one, cycle) for one in cycle):
        return [*cycle]
    forms = [form(line) for line in islice(filter(str.strip, lines), SHOWN)]
    turned = [[*cycle[i:], *cycle[:i]] for i in range(len(cycle))]
    return next((one for i in range(len(forms)) for one in turned
                 if forms[i : i + len(cycle)] == one), [*cycle])


def _samples(
    lines: Sequence[str], forms: Sequence[str], cycle: Sequence[str]
) -> Iterator[tuple[int, list[str]]]:
    """Index of the last line, and the lines, of each sample; lines of other forms are left out."""
    sample: list[str] = []
    for i, (line, one) in enumerate(zip(lines, forms, strict=True)):
        if one != cycle[len(sample)]:
            if one not in cycle:
                continue
            sample = []
        if one == cycle[len(sample)]:
            sample.append(line)
        if len(sample) == len(cycle):
            yield i, sample
            sample = []


def _grow(stamps: Sequence[str]) -> bool:
    """Whether a number increases from row to row, not by one as row numbers do."""
    try:
        numbers = [*map(float, stamps)]
    except ValueError:
        return False
    steps = {other - one for one, other in pairwise(numbers)}
    return len(numbers) > FEWEST_NUMBERS and min(steps) > 0 and steps != {1.0}


def _hide_numbers(lines: Sequence[str]) -> bool:
    """Whether the lines are not a plain table: the names of axes are in each line, numbers have
    labels or units in their cells, or words or brackets and change, or are fewer than a triad in
    most lines."""
    if _most_are_rows(lines):
        return False
    plain = [without_colours(line) for line in lines]
    if any(map(LIST.search, plain)):
        return False
    dialects = [dialect_of(line) for line in plain]
    # A line for each sensor: the last one may be that of a temperature.
    if any(len(axes_among(dialect.cells(line))) >= FEWEST_NUMBERS and SLOT.search(line)
           for line, dialect in [*zip(plain, dialects, strict=True)][-LINES_OF_SENSORS:]):
        return True
    hidden = [[*_hidden(line, dialect)] for line, dialect in zip(plain, dialects, strict=True)]
    numbers = [sum(map(dialect.holds_number, dialect.cells(line)))
               for line, dialect in zip(plain, dialects, strict=True)]
    with_numbers = sum(SLOT.search(line) is not None for line in plain)
    if sum(count >= FEWEST_NUMBERS for count in numbers) <= with_numbers / 2:
        return True
    if sum(any(LABELLED.fullmatch(cell) or ((slot := SLOT.match(cell))
               and spelled_unit(cell[slot.end():])) for cell in cells)
           for cells in hidden) > len(lines) / 2:
        return True
    tokens = [tuple(number for cell in cells for number in SLOT.findall(cell)) for cells in hidden]
    return len(set(tokens)) > len(tokens) / 2


def _most_are_rows(lines: Sequence[str]) -> bool:
    """Whether more than half of the lines, the last ones, hold nothing but a row of numbers."""
    dialect = dialect_of(lines[-1])
    rows = [dialect.cells(line) for line in lines[max(len(lines) // 2 - 1, 0):]]
    return (len(lines) > 1 and not any("|" in line for line in lines)
            and min(map(len, rows)) >= FEWEST_NUMBERS and dialect.hold_numbers([*chain(*rows)]))


def _hidden(line: str, dialect: Dialect) -> Iterator[str]:
    """The cells of a line that are neither a number nor a time."""
    for cell in dialect.cells(line):
        if not dialect.holds_number(cell) and seconds_of(cell) is None and (
                local_date_seconds(cell) is None):
            yield cell

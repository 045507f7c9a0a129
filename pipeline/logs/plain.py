"""Plain tables: our names above rows of decimal numbers between commas, as ``pipeline record``
writes them.

Such a text leaves no question that other logs raise (delimiters, dates, several sensors, words
between the rows), so that NumPy parses it at once, in a quarter of the time.
"""

import re

import numpy as np

from pipeline.logs.columns import READINGS, TIME, missing_columns
from pipeline.logs.dialect import SHOWN
from pipeline.logs.formats.file_table import FileTable, TextFile
from pipeline.logs.header_words import read_name
from pipeline.logs.row_kinds import take_turns

NUMBERS = re.compile(rb"[0-9.,+\-eE\r\n]+")
NO_NUMBER = re.compile(rb"[eE](?![-+])|\n\r?\n.")  #: digits of a register; an empty line
FIRST_LINE = 2  #: fact: the number of the line below the header


def plain_table(text: TextFile) -> FileTable | None:
    """The table of a text that is plain; None of any other.

    A column that is none of ours must be neither a time, nor of another sensor, nor tell sensors
    apart whose rows take turns.
    """
    head, _, rows = text.data.partition(b"\n")
    names = head.rstrip(b"\r").decode("utf-8", "replace").split(",")
    others = [name for name in names if name not in READINGS]
    if TIME not in names or missing_columns(names) is not None or not all(
            name.isidentifier() and name.islower()
            and read_name(name).quantity in ("", "temperature") for name in others):
        return None
    if not NUMBERS.fullmatch(rows) or NO_NUMBER.search(rows):
        return None
    try:
        table = np.loadtxt(rows.decode().splitlines(), delimiter=",", ndmin=2)
    except ValueError:
        return None
    columns = dict(zip(names, table.T, strict=False))
    if table.shape[1] != len(names) or any(
            take_turns(columns[name][-SHOWN:].tolist()) for name in others):
        return None
    return FileTable(text.name, columns, FIRST_LINE)

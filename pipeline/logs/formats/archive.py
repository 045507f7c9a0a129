"""Archives (zip): exports of phone apps with one table of text per sensor; and NumPy's .npz."""

import io
import zipfile
from pathlib import Path, PurePosixPath

import numpy as np

from pipeline.errors import UnreadableInput
from pipeline.logs.formats.file_table import FileTable, columns_of_array, tables_by_length
from pipeline.logs.memory import largest_text, too_large
from pipeline.logs.source import picked_lines, tables_of_text
from pipeline.logs.text import columns_of_text, raw_text

ENCRYPTED = 1  #: bit in a member's flags
TEXT = (".csv", ".txt", ".tsv", ".log")


def tables(path: Path) -> list[FileTable]:
    """The tables of text in an archive, with the names of their files; arrays grouped by length."""
    try:
        with zipfile.ZipFile(path) as archive:
            return _tables(path, archive)
    except zipfile.BadZipFile as error:
        raise _damaged(path, error) from error


def member_lines(path: Path, name: str) -> list[str] | None:
    """The lines of a table of text in an archive; None if it has no text with that name."""
    try:
        with zipfile.ZipFile(path) as archive:
            member = next((member for member in _wanted(path, archive)
                           if f"{name}/".startswith(f"{member.filename}/")), None)
            if member is None or not member.filename.lower().endswith(TEXT):
                return None
            tables = tables_of_text(path / name, archive.read(member))
            return picked_lines(path / member.filename, tables, name[len(member.filename) + 1 :])
    except zipfile.BadZipFile as error:
        raise _damaged(path, error) from error


def _wanted(path: Path, archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    members = [member for member in archive.infolist() if not member.is_dir()]
    if any(member.filename.startswith(("xl/", "content.xml")) for member in members):
        raise UnreadableInput(f"{path}: is a spreadsheet. Save the sheet as CSV.")
    wanted = [member for member in members
              if member.filename.lower().endswith((*TEXT, ".npy"))
              and not Path(member.filename).name.startswith(".")]
    for member in wanted:
        if member.flag_bits & ENCRYPTED:
            raise UnreadableInput(f"{path}: {member.filename} is protected by a password. Unpack "
                                  "the archive, and import its files.")
        if PurePosixPath(member.filename).is_absolute() or ".." in Path(member.filename).parts:
            raise UnreadableInput(f"{path}: the name of its file {member.filename} leads out of "
                                  "the archive. Unpack it where you trust it, and import the file.")
    limit = largest_text()
    if sum(member.file_size for member in wanted) > limit:
        raise too_large(path, limit)
    return wanted


def _tables(path: Path, archive: zipfile.ZipFile) -> list[FileTable]:
    arrays: dict[str, np.ndarray] = {}
    tables = []
    for member in _wanted(path, archive):
        data = archive.read(member)
        name = Path(member.filename)
        if name.suffix == ".npy":
            array = np.load(io.BytesIO(data), allow_pickle=False)
            arrays |= columns_of_array(name.stem, array)
            continue
        for kind, lines in tables_of_text(path / name, data).items():
            text = raw_text(path / name / kind, lines)
            if text is not None:
                tables.append(FileTable((name / kind).as_posix(), columns_of_text(text)[1]))
    return [*tables, *tables_by_length(arrays)]


def _damaged(path: Path, error: Exception) -> UnreadableInput:
    return UnreadableInput(f"{path}: the archive is damaged or cut off ({error}). Export it again.")

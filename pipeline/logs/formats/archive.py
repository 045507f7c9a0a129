"""Archives (zip): exports of phone apps with one table of text per sensor; NumPy's arrays."""

import io
import zipfile
from pathlib import Path, PurePosixPath

import numpy as np

from pipeline.errors import UnreadableInput
from pipeline.logs.formats.file_table import (
    FileTable,
    TextFile,
    columns_of_array,
    tables_by_length,
)
from pipeline.logs.memory import largest_text, too_large

ARRAY = b"\x93NUMPY"  #: first bytes of an array
ENCRYPTED = 1  #: bit in a member's flags
TEXT = (".csv", ".txt", ".tsv", ".log")


def tables(path: Path) -> list[FileTable | TextFile]:
    """The texts in an archive, and its arrays, grouped by length; or an array alone."""
    with path.open("rb") as file:
        if file.read(len(ARRAY)) == ARRAY:
            array = np.load(path, allow_pickle=False)
            return [*tables_by_length(columns_of_array(path.stem, array))]
    try:
        with zipfile.ZipFile(path) as archive:
            return _tables(path, archive)
    except zipfile.BadZipFile as error:
        raise UnreadableInput(f"{path}: the archive is damaged or cut off ({error}). Export it "
                              "again.") from error


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


def _tables(path: Path, archive: zipfile.ZipFile) -> list[FileTable | TextFile]:
    arrays: dict[str, np.ndarray] = {}
    texts = []
    for member in _wanted(path, archive):
        data = archive.read(member)
        name = Path(member.filename)
        if name.suffix == ".npy":
            arrays |= columns_of_array(name.stem, np.load(io.BytesIO(data), allow_pickle=False))
        else:
            texts.append(TextFile(name.as_posix(), data))
    return [*texts, *tables_by_length(arrays)]

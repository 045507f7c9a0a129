"""The format of a file, by its first bytes, and the module that reads it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import TracebackType

from pipeline.errors import NoReadings, UnreadableInput
from pipeline.logs.formats.file_table import FileTable, TextFile
from pipeline.logs.memory import largest_text, too_large
from pipeline.logs.source import require_file
from pipeline.text.names import DISTRIBUTION

BAG_FOLDER_MARK = "metadata.yaml"  #: file that marks a folder as a ROS 2 bag
BAG_SUFFIX = ".db3"  #: suffix of a database that is a ROS 2 bag
HEAD_BYTES = 16  #: the longest mark below has 15; JSON may have blanks before its brace
JSON_BEGINS = re.compile(rb"\s*(\[\s*)?\{\s*(?:[\"'}]|$)")  #: a name without quotes is no JSON


@dataclass(frozen=True)
class Kind:
    """A format: its name, the module that reads it, and the extra that installs its library.

    ``si``: the format states its units, and its tables are in m/s², rad/s and seconds.
    """

    name: str
    module: str
    extra: str | None = None
    si: bool = False

    @property
    def one(self) -> str:
        """The name with its indefinite article."""
        return f"{'an' if self.name[0] in 'aAH' else 'a'} {self.name}"


HDF5 = Kind("HDF5 file", "hdf5", "hdf5")
ROS = Kind("ROS bag", "ros", "ros", si=True)
ARCHIVE = Kind("archive", "archive")
JSON = Kind("JSON file", "json_lines")
KINDS: Mapping[bytes, Kind] = {
    b"PAR1": Kind("Parquet file", "parquet", "parquet"),
    b"ARROW1": Kind("Arrow file", "parquet", "parquet"),
    b"\x89HDF\r\n\x1a\n": HDF5,
    b"MATLAB 5.0": Kind("MATLAB file", "matlab"),
    b"MATLAB 7.3": Kind("MATLAB file", "hdf5", "hdf5"),
    b"\x93NUMPY": Kind("NumPy file", "archive"),
    b"#ROSBAG": ROS,
    b"SQLite format 3": ROS,
    b"\x89MCAP": ROS,
    b"ULog\x01\x12\x35": Kind("PX4 log", "px4", "px4", si=True),
    b"\xa3\x95": Kind("ArduPilot log", "ardupilot", "ardupilot", si=True),
    b"PK\x03\x04": ARCHIVE,
    b"PK\x05\x06": ARCHIVE,  # empty
}
#: Formats that are not read, with advice.
OTHERS: Mapping[bytes, str] = {
    b"\xd0\xcf\x11\xe0": "a spreadsheet of Excel 97. Save the sheet as CSV",
    b"H Product:": "a Betaflight or INAV log as the flash memory holds it. Decode it with "
                   "`blackbox_decode`, and import the CSV",
    b"\xfa\xff": "the bytes of an Xsens. `pipeline record` reads them; export a text with MT "
                 "Manager",
    b"%PDF": "a PDF",
    **{mark: f"packed by {name}. Unpack it, and import the log in it" for mark, name in (
        (b"BZh", "bzip2"), (b"\xfd7zXZ", "xz"), (b"(\xb5/\xfd", "Zstandard"),
        (b"7z\xbc\xaf", "7-Zip"), (b"Rar!", "RAR"))},
    b"SQLite format 3": "a database of SQLite. Write its table as text, for example by `sqlite3 "
                        "-header -csv FILE 'select * from imu' > imu.csv` (`.tables` lists the "
                        "tables), and import that",
}


def kind_of(path: Path) -> Kind | None:
    """The kind of a file, None for text.

    Raises
    ------
    UnreadableInput
        It cannot be read, or is of a known kind that is not supported.
    """
    if path.is_dir():
        if not (path / BAG_FOLDER_MARK).is_file():
            raise UnreadableInput(f"{path}: is a folder; a file is expected, or the folder of a "
                                  f"ROS 2 bag with its {BAG_FOLDER_MARK}.")
        return ROS
    try:
        require_file(path)
        with path.open("rb") as file:
            head = file.read(HEAD_BYTES)
    except OSError as error:
        raise UnreadableInput(f"{path}: cannot be read ({error.strerror}). Check the name, and "
                              "that you may read the file.") from error
    for mark, instead in OTHERS.items():
        if head.startswith(mark) and path.suffix != BAG_SUFFIX:
            raise UnreadableInput(f"{path}: is {instead}.")
    if JSON_BEGINS.match(head):
        return JSON
    return next((kind for mark, kind in KINDS.items() if head.startswith(mark)), None)


class _LibraryCode:
    """Context of a call of a format's library: any error of it means that the file is unreadable.

    Libraries raise arbitrary errors on a damaged file, including those of their own bugs.
    """

    def __init__(self, path: Path, kind: Kind) -> None:
        self._path, self._kind = path, kind

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 _trace: TracebackType | None) -> None:
        passes = (UnreadableInput, MemoryError, KeyboardInterrupt, SystemExit)
        if kind is not None and not issubclass(kind, passes):
            raise UnreadableInput(
                f"{self._path}: looks like {self._kind.one} but cannot be read ({kind.__name__}: "
                f"{' '.join(str(error).split())}). It may be cut off; copy it again from where it "
                f"was made."
            ) from error


def tables_of(path: Path, kind: Kind) -> list[FileTable | TextFile]:
    """Read all tables of a file, and the texts of an archive.

    Raises
    ------
    UnreadableInput
        The library of the format is not installed, or the file is damaged or holds no numbers.
    """
    limit = largest_text()
    if path.is_file() and path.stat().st_size > limit:
        raise too_large(path, limit)
    try:
        module = import_module(f"pipeline.logs.formats.{kind.module}")
    except ImportError as error:
        raise UnreadableInput(
            f"{path}: is {kind.one}; reading it needs {error.name}, which is not installed. "
            f"Type: pip install '{DISTRIBUTION}[{kind.extra}]'"
        ) from error
    with _LibraryCode(path, kind):
        tables: list[FileTable | TextFile] = module.tables(path)
    if not tables:
        raise NoReadings(f"{path}: this {kind.name} holds no readings of an accelerometer or a "
                         "gyroscope: no table in it has three axes beside each other.")
    return tables


def is_log_file(path: Path) -> bool:
    """Whether a path names a file, a bag, or a table in one of them."""
    return _file_in(path) is not None


def split_member(path: Path) -> tuple[Path, str]:
    """A file and the name of one of its tables, from a path like ``phone.zip/Accelerometer.csv``.

    The name is empty if the path is that of the file.
    """
    file = _file_in(path)
    if file is None or file == path:
        return path, ""
    return file, path.relative_to(file).as_posix()


def _file_in(path: Path) -> Path | None:
    """The file or bag at ``path``, or the one whose table it names; None if there is none."""
    for file in (path, *path.parents):
        if file.is_file():
            return file
        if file.is_dir():  # above a folder there is no file
            return file if (file / BAG_FOLDER_MARK).is_file() else None
    return None

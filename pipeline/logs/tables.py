"""The tables of a file before their columns are named: rows of text, or columns of numbers."""

from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import UnreadableInput
from pipeline.logs.formats.file_table import FileTable, TextFile
from pipeline.logs.formats.kinds import kind_of, split_member, tables_of
from pipeline.logs.plain import plain_table
from pipeline.logs.reshaped import tables_beside, with_names_in_header, with_whole_stamps
from pipeline.logs.row_kinds import lines_by_kind
from pipeline.logs.sentences import rows_of_lines
from pipeline.logs.source import read_bytes, text_lines
from pipeline.text.names import nearest_name


@dataclass(frozen=True, eq=False)
class TextTable:
    """A table as rows of text by the line numbers of the file; its name is empty if that has no
    other."""

    name: str
    lines: list[str]


def tables_in(path: Path) -> list[TextTable | FileTable]:
    """The tables of the file at ``path``, or the one in it that the path names.

    Raises
    ------
    UnreadableInput
        The file cannot be read, or holds no table with this name.
    """
    file, member = split_member(path)
    kind = kind_of(file)
    parts = tables_of(file, kind) if kind else [TextFile("", read_bytes(file))]
    tables: list[TextTable | FileTable] = []
    for part in parts:
        if isinstance(part, FileTable):
            tables.append(part)
        elif not member or f"{member}/".startswith(f"{part.name}/".lstrip("/")):
            plain = plain_table(part)
            tables += [plain] if plain else _tables_of_text(file, part)
    named = [table for table in tables if member in ("", table.name)]
    if not named:
        names = [table.name for table in (tables or parts) if table.name]
        raise UnreadableInput(
            f"{path}: no table is named '{member}'{nearest_name(member, names)}; there are: "
            f"{', '.join(names)}." if names else
            f"{file}: is one table of text and has no '{member}'. Name the file alone.")
    return named


def _tables_of_text(file: Path, text: TextFile) -> list[TextTable]:
    """The tables of a text: one, or one for each kind of rows."""
    lines = with_names_in_header(text_lines(file / text.name, text.data))
    tables = tables_beside(lines) or lines_by_kind(lines)
    return [TextTable("/".join(filter(None, (text.name, kind))),
                      with_whole_stamps(rows_of_lines(those)))
            for kind, those in tables.items()]

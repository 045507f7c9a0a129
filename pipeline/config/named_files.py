"""The files on which the results of a configuration depend."""

from collections.abc import Iterator
from pathlib import Path

from pipeline.cameras import cameras_file
from pipeline.config.schema import TimebaseSection
from pipeline.config.session import Config
from pipeline.config.types import Section


def named_files(config: Config) -> Iterator[Path]:
    """Every file that a configuration names, itself excepted; some more than once.

    The clocks of the user's cameras are among them where it names a camera.
    """
    yield from _in(config)
    for effect in config.effects.values():
        if effect.python is not None:
            yield config.source.path.parent / effect.python.partition(":")[0]


def _in(value: object) -> Iterator[Path]:
    """The files in the values of a section, of a mapping or of a list."""
    if isinstance(value, Path):
        yield from _files(value)
    elif isinstance(value, TimebaseSection) and value.camera is not None:
        yield cameras_file()
    elif isinstance(value, Section | dict):
        for one in (dict(value) if isinstance(value, Section) else value).values():
            yield from _in(one)
    elif isinstance(value, list | tuple):
        for one in value:
            yield from _in(one)


def _files(path: Path) -> Iterator[Path]:
    """The files of a path: itself, all in a folder, or the archive that contains it."""
    if path.is_dir():
        yield from (one for one in path.rglob("*") if one.is_file())
        return
    yield next((one for one in (path, *path.parents) if one.is_file()), path)
